// Lines over the picture: edges of the bows, horizon, the sun and the point opposite to it; where the drops are.

const NAMESPACE = 'http://www.w3.org/2000/svg';
const svg = document.getElementById('marks');

function element(kind, attributes, title) {
  const made = document.createElementNS(NAMESPACE, kind);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (title) made.append(Object.assign(document.createElementNS(NAMESPACE, 'title'), { textContent: title }));
  return made;
}

const points = (line) => line.map(([x, y]) => `${x.toFixed(2)},${y.toFixed(2)}`).join(' ');

const groups = Object.fromEntries(['lines', 'drops', 'picks'].map((name) => [name, svg.appendChild(element('g', { class: name }))]));

// Where the bow was picked in a photograph, in pixels of the picture.
export function picks({ size, photograph_size: own, values }) {
  const found = own ? values.photo?.picks_px ?? [] : [];
  return found.map(([x, y]) => [x * (size[0] / own[0]), y * (size[1] / own[1])]);
}

export function mark(scene) {
  const { size, marks } = scene;
  svg.setAttribute('viewBox', `0 0 ${size[0]} ${size[1]}`);
  svg.setAttribute('preserveAspectRatio', 'none');
  const lines = marks.bows.flatMap(({ bow, color, lines }) => lines.map((line) => element('polyline', { class: `${bow} ${color}`, points: points(line) })));
  const horizon = marks.horizon.map((line) => element('polyline', { class: 'horizon', points: points(line) }));
  const radius = size[0] / 120;
  const spots = [['antisolar', marks.antisolar_px], ['sun', marks.sun_px]]
    .filter(([, place]) => place)
    .map(([name, [cx, cy]]) => element('circle', { class: name, cx, cy, r: radius }));
  groups.lines.replaceChildren(...horizon, ...lines, ...spots);
  groups.picks.replaceChildren(...picks(scene).map(([cx, cy]) => element('circle', { class: 'pick', cx, cy, r: radius })));
}

// The boxes that the drops of a picture are in, whose edges are given in parts of the frame.
export function markDrops(edges, [width, height]) {
  groups.drops.replaceChildren(...edges.map((line) => element('polyline', { points: points(line.map(([x, y]) => [x * width, y * height])) })));
}

export function showMarks(name, isShown) {
  groups[name].style.display = isShown ? '' : 'none';
}
