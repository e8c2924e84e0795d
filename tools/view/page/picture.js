// The picture on the canvas: the newest, beside the one that was kept as A.

import { develop } from './tone.js';

const canvas = document.getElementById('canvas');
const frame = document.getElementById('frame');
const wipe = document.getElementById('wipe');

const shown = { newest: null, kept: null, exposureEv: 0, gains: [1, 1, 1] };
let isDrawing = false;

export function show(change) {
  Object.assign(shown, change);
  if (isDrawing || !shown.newest) return;
  isDrawing = true;
  requestAnimationFrame(() => {
    isDrawing = false;
    draw();
  });
}

export const newest = () => shown.newest;

export function keep() {
  shown.kept = shown.kept ? null : shown.newest;
  wipe.hidden = !shown.kept;
  show({});
  return Boolean(shown.kept);
}

function image(picture) {
  const developed = new ImageData(picture.width, picture.height);
  develop(picture, developed.data, shown.exposureEv, shown.gains);
  return developed;
}

function draw() {
  const { newest, kept } = shown;
  canvas.width = newest.width;
  canvas.height = newest.height;
  const context = canvas.getContext('2d');
  context.putImageData(image(newest), 0, 0);
  if (kept) {
    // A stands left of the wipe, stretched where it has other pixels.
    const part = Math.round(wipe.valueAsNumber * newest.width);
    const other = new OffscreenCanvas(kept.width, kept.height);
    other.getContext('2d').putImageData(image(kept), 0, 0);
    const scale = kept.width / newest.width;
    if (part > 0) context.drawImage(other, 0, 0, part * scale, kept.height, 0, 0, part, newest.height);
    context.fillStyle = '#fff';
    context.fillRect(part, 0, Math.max(1, newest.width / 640), newest.height);
  }
  canvas.dataset.picture = newest.number;
  canvas.dataset.level = newest.level;
}

// As large as there is room, in the shape of the whole picture.
export function fit([width, height]) {
  const stage = document.getElementById('stage');
  const room = [stage.clientWidth - 26, Math.max(200, stage.clientHeight - 270)];
  const scale = Math.min(room[0] / width, room[1] / height);
  frame.style.width = `${Math.floor(width * scale)}px`;
  frame.style.height = `${Math.floor(height * scale)}px`;
}

wipe.addEventListener('input', () => show({}));
