// Where the sun stands: by elevation and azimuth, by date and place, or by points of its bow in a photograph.

import { fill, make } from './elements.js';

const WAYS = ['elevation and azimuth', 'date and place'];
const PICKED = 'points of the bow';
// When and where, for a scene that has not been asked for it yet: a summer evening in Munich.
let moment = { date_time: '2026-06-21T18:30:00+02:00', latitude_deg: 48.1, longitude_deg: 11.6 };

const isTimed = ({ values }) => 'date_time' in (values.sun ?? {});
const none = (keys) => Object.fromEntries(Object.keys(keys).map((key) => [key, null]));

// The way; by elevation and azimuth the sun stays where it was, by date and place it goes to where those were last.
export function sunField(controls) {
  const path = 'sun by';
  const isPicked = () => !controls.scene.values.sun;
  const ways = isPicked() ? [PICKED, ...WAYS] : WAYS;
  const choice = make('select', { id: path, className: 'wide' }, ...ways.map((name) => make('option', { value: name, textContent: name })));
  choice.addEventListener('change', () => {
    const { sun } = controls.scene;
    const stands = { elevation_deg: Number(sun.elevation_deg.toFixed(3)), azimuth_deg: Number(sun.azimuth_deg.toFixed(3)) };
    const keys = choice.value === WAYS[1] ? { ...none(stands), ...moment } : { ...none(moment), ...stands };
    controls.changeAll(Object.fromEntries(Object.entries(keys).map(([key, value]) => [`sun.${key}`, value])), path);
  });
  const row = controls.frame(path, 'Where the sun stands, or when and where it is looked at', choice);
  const show = () => {
    choice.value = isPicked() ? PICKED : WAYS[Number(isTimed(controls.scene))];
    if (!isTimed(controls.scene)) return;
    const { date_time, latitude_deg, longitude_deg } = controls.scene.values.sun;
    moment = { date_time, latitude_deg, longitude_deg };
  };
  controls.fields.set(path, { row, show });
  return row;
}

// Date and time with its zone, and a slider for the time of that day.
export function momentField(controls, path, what) {
  const box = make('input', { type: 'text', id: path, className: 'wide' });
  const slider = make('input', { type: 'range', min: 0, max: 1439, step: 1, className: 'wide' });
  slider.setAttribute('aria-label', 'time of the day, slider');
  const parts = () => box.value.match(/^(.*[T ])(\d\d):(\d\d)(.*)$/);
  const two = (value) => String(value).padStart(2, '0');
  let gesture = null;
  slider.addEventListener('input', () => {
    gesture = gesture ?? `${path} ${Math.random()}`;
    const [, date, , , rest] = parts();
    box.value = `${date}${two(Math.floor(slider.valueAsNumber / 60))}:${two(slider.valueAsNumber % 60)}${rest}`;
    controls.change(path, box.value, gesture);
  });
  slider.addEventListener('change', () => { gesture = null; });
  box.addEventListener('change', () => controls.change(path, box.value));
  const row = controls.frame(path, what, box, slider);
  controls.fields.set(path, {
    row,
    show: (found) => {
      fill(box, found, row);
      const known = parts();
      slider.disabled = !known;
      if (known && !gesture) slider.value = 60 * Number(known[2]) + Number(known[3]);
    },
  });
  return row;
}
