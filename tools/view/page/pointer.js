// What is known of the place under the pointer: light, spectrum, angle.

import { ask } from './server.js';

const reading = document.getElementById('reading');
const spectrum = document.getElementById('spectrum');
const canvas = document.getElementById('canvas');
let wanted = null;
let isAsking = false;

const digits = (value, n = 3) => (value === 0 ? '0' : value.toPrecision(n));

function told(at) {
  const rows = [['light', `${digits(at.luminance_cd_m2)} cd/m² (${digits(100 * at.of_white)} % of white)`]];
  if (at.error_of_white !== null) rows.push(['error', `${digits(100 * at.error_of_white, 2)} % of white`]);
  if (at.bow_angle_deg !== null) rows.push(['bow angle', `${at.bow_angle_deg.toFixed(2)}°`]);
  if (at.passes !== null) rows.push(['drops let pass', `${digits(100 * at.passes)} %`]);
  if (at.effective_radius_um !== null) rows.push(['drops’ radius', `${Number(digits(at.effective_radius_um))} µm`]);
  if (at.distance_m > 0) rows.push(['drops’ light from', `${digits(at.distance_m)} m`]);
  reading.replaceChildren(...rows.flatMap(([name, value]) => [element('dt', name), element('dd', value)]));
  plot(at.wavelength_nm, at.radiance);
}

function element(kind, text) {
  return Object.assign(document.createElement(kind), { textContent: text });
}

function plot(nm, radiance) {
  const most = Math.max(...radiance, 1e-30);
  const [first, last] = [nm[0], nm.at(-1)];
  const x = (value) => 8 + (304 * (value - first)) / Math.max(last - first, 1);
  const points = nm.map((value, index) => `${x(value).toFixed(1)},${(100 - (86 * radiance[index]) / most).toFixed(1)}`).join(' ');
  const label = (at, y, text, anchor) => `<text x="${at}" y="${y}" text-anchor="${anchor}">${text}</text>`;
  spectrum.innerHTML = `<polyline points="${points}"/>${label(8, 115, `${first.toFixed(0)} nm`, 'start')}${label(312, 115, `${last.toFixed(0)} nm`, 'end')}${label(312, 11, `${most.toExponential(2)} W/m² sr nm`, 'end')}`;
}

// Asks for the newest place only.
export async function read(place) {
  wanted = place ?? wanted;
  if (isAsking || !wanted) return;
  isAsking = true;
  const [right, down] = wanted;
  wanted = null;
  try {
    told(await ask(`at?right=${right}&down=${down}`));
  } catch {
    // No picture is there yet, or none at that place.
  }
  isAsking = false;
  if (wanted) read();
}

export function place(event) {
  const box = canvas.getBoundingClientRect();
  return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
}
