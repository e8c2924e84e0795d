// The page: what the program tells is shown, what a hand does is told to the program.

import { ask, pixels } from './server.js';
import { whiteGains } from './tone.js';
import * as picture from './picture.js';
import { mark, markDrops, picks, showMarks } from './marks.js';
import { Controls } from './controls.js';
import { place, read } from './pointer.js';

const by = (id) => document.getElementById(id);
let scene = null;
let controls = null;

function take(told) {
  if (scene && told.revision < scene.revision) return;
  scene = told;
  document.title = `${scene.is_edited ? '• ' : ''}${scene.name} – niji view`;
  by('name').textContent = scene.name;
  by('path').textContent = scene.path + (scene.is_edited ? ' – not saved' : '');
  by('undo').disabled = !scene.can_undo;
  by('redo').disabled = !scene.can_redo;
  by('save').disabled = !scene.is_edited;
  by('command').textContent = scene.command;
  by('exposure').disabled = 'photo' in scene.values;
  if (document.activeElement !== by('exposure')) by('exposure').value = scene.exposure_ev;
  expose(by('exposure').valueAsNumber);
  picture.fit(scene.size);
  mark(scene);
  controls.show(scene);
}

function expose(exposureEv) {
  by('exposure-value').textContent = `${exposureEv.toFixed(2)} EV`;
  picture.show({ exposureEv });
}

// Changes are sent one after the other; those of one movement that wait become one.
let queue = Promise.resolve();
let waiting = null;
function set(values, gesture, path = 'set') {
  if (waiting && gesture && waiting.gesture === gesture && waiting.path === path) {
    Object.assign(waiting.values, values);
    return waiting.done;
  }
  const change = { values, gesture, path };
  waiting = change;
  change.done = inTurn(async () => {
    if (waiting === change) waiting = null;
    take(await ask(path, { values, gesture }));
  });
  return change.done;
}

// What is to be done after all that was asked for before.
function inTurn(work) {
  const done = queue.then(work);
  queue = done.catch(() => {});
  return done;
}

function say(text) {
  by('message').textContent = text;
  by('message').hidden = !text;
}

async function act(path) {
  say('');
  try {
    take(await ask(path, {}));
  } catch (error) {
    say(error.message);
  }
}

// What is being typed counts when its field is left: that comes before the file is written.
async function save() {
  const field = document.activeElement;
  if (field?.matches('input, textarea')) {
    field.blur();
    field.focus();
  }
  await queue;
  // What is wrong is told where it stands one turn later.
  await Promise.resolve();
  if (document.querySelector('#controls .wrong')) say('nothing was saved: a value was refused, as is told beside it');
  else await act('save');
}

// A bow through picks in a photograph follows the hand, and its picks with it.
function dragPicks([dx, dy], gesture) {
  const { clientWidth, clientHeight } = by('canvas');
  const from = drag?.place ?? [0.5, 0.5];
  const to = [from[0] + dx / clientWidth, from[1] + dy / clientHeight];
  const picks_px = drag?.picks ?? scene.values.photo.picks_px;
  set({ picks_px, from, to }, gesture, 'drag-picks').then(() => say(''), (error) => say(error.message));
}

// The sun follows the hand: the point opposite to it moves with the pointer.
let drag = null;
function moveSun([dx, dy], gesture) {
  const sun = scene.values.sun ?? {};
  if (!scene.degrees_per_pixel) return;
  if (picks(scene).length > 0) {
    dragPicks([dx, dy], gesture);
    return;
  }
  if (sun.elevation_deg === undefined) {
    say('the sun stands where date and place say: choose "elevation and azimuth" to move it by hand');
    return;
  }
  const scale = scene.degrees_per_pixel * (scene.size[0] / by('canvas').clientWidth);
  const from = drag ?? { elevation: sun.elevation_deg, azimuth: sun.azimuth_deg };
  const round = (value) => Math.round(100 * value) / 100;
  set({
    'sun.elevation_deg': round(Math.max(-90, Math.min(90, from.elevation + dy * scale))),
    'sun.azimuth_deg': round((((from.azimuth + dx * scale) % 360) + 360) % 360),
  }, gesture).catch((error) => say(error.message));
}

function listen() {
  const canvas = by('canvas');
  by('exposure').addEventListener('input', () => {
    const exposureEv = by('exposure').valueAsNumber;
    expose(exposureEv);
    set({ 'picture.exposure_ev': exposureEv }, 'exposure').catch((error) => say(error.message));
  });
  by('white').addEventListener('input', () => {
    by('white-value').textContent = `${by('white').value} K`;
    picture.show({ gains: whiteGains(by('white').valueAsNumber) });
  });
  for (const name of ['lines', 'drops']) {
    const box = by(`show-${name}`);
    const show = () => showMarks(name, box.checked);
    box.addEventListener('change', show);
    show();
  }
  by('keep').addEventListener('click', () => {
    by('keep').textContent = picture.keep() ? 'Drop A' : 'Keep as A';
  });
  by('save').addEventListener('click', save);
  for (const path of ['undo', 'redo', 'again']) by(path).addEventListener('click', () => act(path));
  by('copy').addEventListener('click', async () => {
    await navigator.clipboard.writeText(scene.command);
    by('copy').textContent = 'Copied';
  });
  canvas.addEventListener('pointermove', (event) => {
    read(place(event));
    if (drag) moveSun([event.clientX - drag.x, event.clientY - drag.y], drag.gesture);
  });
  canvas.addEventListener('pointerdown', (event) => {
    const sun = scene.values.sun ?? {};
    canvas.setPointerCapture(event.pointerId);
    const { clientX: x, clientY: y } = event;
    drag = {
      x, y, elevation: sun.elevation_deg, azimuth: sun.azimuth_deg, gesture: `drag ${Math.random()}`,
      picks: scene.values.photo?.picks_px, place: place(event),
    };
  });
  for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { drag = null; });
  canvas.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!step) return;
    event.preventDefault();
    moveSun(step.map((it) => it * (event.shiftKey ? 10 : 2)), 'arrow keys');
  });
  addEventListener('keydown', (event) => {
    const isTyping = event.target.matches('input[type=number], input[type=text], textarea, select');
    const command = event.ctrlKey || event.metaKey;
    if (command && event.key === 's') save();
    else if (command && event.key.toLowerCase() === 'z' && !isTyping) act(event.shiftKey ? 'redo' : 'undo');
    else if (!command && !isTyping && event.key === 'o') by('show-lines').click();
    else if (!command && !isTyping && event.key === 'd') by('show-drops').click();
    else if (!command && !isTyping && event.key === 'a') by('keep').click();
    else return;
    event.preventDefault();
  });
  addEventListener('resize', () => picture.fit(scene.size));
}

// Follows what happens, for as long as the program is there.
async function follow() {
  let after = 0;
  let trouble = '';
  for (;;) {
    let news;
    try {
      news = await ask(`news?after=${after}`);
    } catch {
      by('status').textContent = 'the program has ended: start it again, and open the address that it prints';
      return;
    }
    after = news.event;
    if (news.revision > scene.revision) take(await ask('scene'));
    const [what, part] = news.progress ?? [null, 1];
    by('progress').value = part;
    if (trouble !== (news.trouble ?? '')) say(trouble = news.trouble ?? '');
    controls.showPlan(news.plan);
    const newest = news.picture;
    if (newest && newest.number !== picture.newest()?.number) {
      const rgb = await pixels(newest.number);
      if (rgb) picture.show({ newest: { ...newest, rgb, width: newest.size[0], height: newest.size[1] } });
      markDrops(newest.drops, scene.size);
      read();
    }
    const done = newest ? `${newest.level}, ${newest.size.join(' × ')} after ${newest.seconds.toFixed(2)} s` : '';
    const error = newest?.is_finished && newest.error_of_white !== null ? `, error ${(100 * newest.error_of_white).toPrecision(2)} % of white` : '';
    by('status').textContent = what ? `${done}${done ? '; ' : ''}${what} …` : done + error;
    by('status').dataset.finished = !what && newest?.is_finished === true;
  }
}

async function start() {
  const [schema, told] = await Promise.all([ask('schema'), ask('scene')]);
  controls = new Controls(schema, set);
  controls.onText = async (text, of) => {
    controls.textNote.replaceChildren();
    try {
      await inTurn(async () => take(await ask('text', { text, of })));
    } catch (error) {
      controls.textNote.replaceChildren(Object.assign(document.createElement('div'), { className: 'wrong', role: 'alert', textContent: error.message }));
    }
  };
  by('white-value').textContent = '6504 K';
  take(told);
  listen();
  await follow();
}

start();
