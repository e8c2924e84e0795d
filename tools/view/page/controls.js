// Controls made from the schema of scenes: a section each, a field for every key.

import { fill, make } from './elements.js';
import { momentField, sunField } from './sun.js';

const panel = document.getElementById('controls');
const warnings = document.getElementById('warnings');

// What is opened at first, and what is not shown: format, name and sections of other pictures.
const OPEN = ['sun', 'drops'];
const ORDER = ['sun', 'drops', 'camera', 'air', 'ground', 'water', 'drop_motion', 'water_surface', 'spectrum', 'accuracy', 'photo', 'picture'];
// Sliders of keys whose range in the schema is far wider than what people set.
const USUAL = { azimuth_deg: [0, 360], elevation_deg: [-10, 90], roll_deg: [-45, 45], exposure_ev: [-8, 12], horizontal_fov_deg: [5, 175], visibility_km: [0.05, 100] };
// From where on a range is gone through by factors.
const WIDE = 100;

const UNITS = { deg: '°', m: 'm', px: 'px', um: 'µm', nm: 'nm', mm: 'mm', km: 'km', c: '°C', ev: 'EV', hpa: 'hPa' };

// 'rain_rate_mm_h' as what it is and its unit.
function words(key) {
  const rate = key.match(/^(.*)_(mm_h|m_s|kg_s|kg_m2_s|g_m3|per_mille|1_s)$/);
  const units = { mm_h: 'mm/h', m_s: 'm/s', kg_s: 'kg/s', kg_m2_s: 'kg/m²s', g_m3: 'g/m³', per_mille: '‰', '1_s': '1/s' };
  if (rate) return [rate[1].replaceAll('_', ' '), units[rate[2]]];
  const parts = key.split('_');
  const unit = parts.length > 1 && UNITS[parts.at(-1)];
  if (key.endsWith('_m3')) return [parts.slice(0, -1).join(' '), '1/m³'];
  return unit ? [parts.slice(0, -1).join(' '), unit] : [parts.join(' '), ''];
}

export class Controls {
  // `set` takes values by their keys and the name of the movement that they belong to.
  constructor(schema, set) {
    this.schema = schema;
    this.set = set;
    this.fields = new Map();
    this.shape = '';
  }

  resolved(schema) {
    const seen = schema.$ref ? { ...this.schema.$defs[schema.$ref.split('/').pop()], ...schema } : schema;
    return seen.$ref && seen !== schema ? { ...seen, $ref: undefined } : seen;
  }

  // Shows a scene; fields are made anew only where it has other keys.
  show(scene) {
    this.asked = scene.values.effects ?? {};
    this.scene = scene;
    const shape = JSON.stringify(scene.values, (_, value) => (typeof value === 'number' ? 0 : value));
    if (shape !== this.shape) {
      this.shape = shape;
      this.build(scene);
    }
    for (const [path, field] of this.fields) {
      const value = at(scene.values, path);
      // A refused value is gone as soon as the scene has another one than when it was refused.
      if (field.refusedFor !== undefined && field.refusedFor !== spelled(value)) this.right(path);
      field.show(value);
    }
    if (document.activeElement !== this.text) this.text.value = scene.text;
    this.text.dataset.of = scene.revision;
  }

  build(scene) {
    const opened = new Set([...panel.querySelectorAll('details[open]')].map((it) => it.dataset.path));
    const isFirst = panel.childElementCount === 0;
    this.fields.clear();
    const isShown = (key) => key in this.schema.properties && (key !== 'photo' || 'photo' in scene.values);
    const sections = ORDER.filter(isShown).map((key) => {
      const fields = this.fieldsOf(this.schema.properties[key], key, scene.values[key]);
      if (key === 'sun') fields.unshift(sunField(this));
      const section = make('details', {}, make('summary', { textContent: words(key)[0] }), ...fields);
      section.dataset.path = key;
      section.open = isFirst ? OPEN.includes(key) : opened.has(key);
      return section;
    });
    this.effects = this.effects ?? make('details', {}, make('summary', { textContent: 'effects' }));
    this.effects.dataset.path = 'effects';
    this.text = this.text ?? this.textField();
    const text = make('details', {}, make('summary', { textContent: 'the whole text' }), this.text, this.textNote);
    text.dataset.path = 'text';
    text.open = opened.has('text');
    panel.replaceChildren(...sections.slice(0, 3), this.effects, ...sections.slice(3), text);
    // What has no field of its own is told at its section.
    for (const section of sections) this.fields.get(section.dataset.path) ?? this.fields.set(section.dataset.path, plain(section));
  }

  // The fields of a part of the scene; of several variants those of the one that is there.
  fieldsOf(schema, path, value) {
    const given = this.resolved(schema);
    // One table, or a list of them.
    const part = given.then && !Array.isArray(value) ? this.resolved(given.then) : given;
    if (Array.isArray(value) && value.every((item) => item && typeof item === 'object' && !Array.isArray(item))) {
      return value.map((item, index) => {
        const inner = this.fieldsOf(part.items ?? {}, `${path}.${index}`, item);
        return make('fieldset', {}, make('legend', { textContent: item.name ?? `${path} ${index + 1}` }), ...inner);
      });
    }
    const properties = this.properties(part, value ?? {});
    const written = (key) => value && key in value;
    const all = Object.entries(properties).map(([key, inner]) => [written(key), this.field(inner, `${path}.${key}`, value?.[key])]).filter(([, field]) => field);
    const shown = all.filter(([isWritten]) => isWritten).map(([, field]) => field);
    const more = all.filter(([isWritten]) => !isWritten).map(([, field]) => field);
    if (more.length === 0) return shown;
    const rest = make('details', {}, make('summary', { textContent: shown.length ? 'more' : 'keys that are left out' }), ...more);
    rest.dataset.path = `${path} more`;
    return [...shown, rest];
  }

  properties(part, value) {
    let found = { ...(part.properties ?? {}) };
    for (const branch of [...(part.anyOf ?? []), ...(part.oneOf ?? [])].map((it) => this.resolved(it))) {
      // A variant by its only key, as a size law.
      const keys = Object.keys(branch.properties ?? {});
      if (branch.type === 'array' || !keys.length) continue;
      if (part.properties === undefined && keys.every((key) => !(branch.required ?? []).includes(key) || key in value)) found = { ...found, ...this.properties(branch, value) };
    }
    // Of several ways to say a thing the keys of the one that is taken.
    for (const { required = [], properties = {} } of part.oneOf ?? []) {
      if (!part.properties || !required.every((key) => key in value)) continue;
      for (const key of Object.keys(properties)) if (properties[key] === false) delete found[key];
    }
    for (const { if: condition, then } of part.allOf ?? []) {
      if (!condition || !then) continue;
      const fits = Object.entries(condition.properties ?? {}).every(([key, wanted]) => wanted === false ? !(key in value) : value[key] === wanted.const);
      if (fits && then.properties) found = { ...this.properties(this.resolved(then), value) };
    }
    return found;
  }

  field(schema, path, value) {
    const part = this.resolved(schema);
    const key = path.split('.').pop();
    // Of several kinds of value that of the one it has.
    const ways = (part.anyOf ?? []).map((it) => this.resolved(it));
    const namesOf = (way) => way.enum ?? (way.oneOf ?? []).map((it) => it.const ?? it.enum).flat().filter((it) => typeof it === 'string');
    const names = typeof value === 'string' ? [part, ...ways].flatMap(namesOf) : namesOf(part);
    const what = part.description ?? schema.description ?? '';
    if (part.type === 'number' || part.type === 'integer') return this.numberField(part, path, what);
    if (part.type === 'array' && part.items && this.resolved(part.items).type === 'number' && part.maxItems <= 3) return this.placeField(part, path, what);
    if (part.type === 'boolean') return this.choiceField(['true', 'false'], path, what, (name) => name === 'true');
    if (key === 'date_time') return momentField(this, path, what);
    if (names.length > 1 && (value === undefined || typeof value === 'string')) return this.choiceField(names, path, what, (name) => name);
    if (value && typeof value === 'object') {
      const fields = this.fieldsOf(schema, path, value);
      if (!fields.length) return null;
      const group = make('details', { open: true, title: what }, make('summary', { textContent: words(key)[0] }), ...fields);
      group.dataset.path = path;
      return group;
    }
    if (typeof value === 'number') return this.numberField(ways.find((way) => way.type === 'number') ?? { type: 'number' }, path, what);
    return null;
  }

  frame(path, what, ...inner) {
    const [name, unit] = words(path.split('.').pop());
    const label = make('label', { htmlFor: path, title: `${what}\n${path}` }, name);
    if (unit) label.append(' ', make('span', { className: 'unit', textContent: unit }));
    const row = make('div', { className: 'field' }, label, ...inner);
    row.dataset.path = path;
    return row;
  }

  numberField(part, path, what) {
    const key = path.split('.').pop();
    const least = part.minimum ?? part.exclusiveMinimum;
    const most = part.maximum ?? part.exclusiveMaximum;
    const step = part.type === 'integer' ? 1 : 'any';
    const box = make('input', { type: 'number', id: path, step, placeholder: part.default ?? '' });
    const slider = make('input', { type: 'range', min: 0, max: 1000, step: 1 });
    slider.setAttribute('aria-label', `${key}, slider`);
    // A range to go through, around the value where the schema has none that a hand can go through.
    let from = 0;
    let to = 1;
    let isByFactors = false;
    const range = (value) => {
      [from, to] = USUAL[key] ?? [least ?? -Infinity, most ?? Infinity];
      isByFactors = false;
      if (to - from > WIDE && !USUAL[key]) {
        isByFactors = value > 0 && !(from < 0);
        [from, to] = isByFactors ? [Math.max(value / 10, least || 0), Math.min(value * 10, most ?? Infinity)] : [Math.max(value - 50, from), Math.min(value + 50, to)];
      }
      if (key === 'visibility_km') isByFactors = true;
    };
    const value = () => {
      const part1000 = slider.valueAsNumber / 1000;
      const found = isByFactors ? from * (to / from) ** part1000 : from + (to - from) * part1000;
      return step === 1 ? Math.round(found) : Number(found.toPrecision(4));
    };
    let gesture = null;
    slider.addEventListener('input', () => {
      gesture = gesture ?? `${path} ${Math.random()}`;
      box.value = value();
      this.change(path, value(), gesture);
    });
    slider.addEventListener('change', () => { gesture = null; });
    box.addEventListener('change', () => this.change(path, box.value === '' ? null : box.valueAsNumber));
    const row = this.frame(path, what, slider, box);
    this.fields.set(path, {
      row,
      show: (found) => {
        fill(box, found, row);
        slider.disabled = typeof found !== 'number';
        if (gesture || slider.disabled) return;
        if (!(found >= from && found <= to) || to === 1) range(found);
        slider.value = 1000 * (isByFactors ? Math.log(found / from) / Math.log(to / from) : (found - from) / (to - from));
      },
    });
    return row;
  }

  placeField(part, path, what) {
    const boxes = Array.from({ length: part.maxItems }, (_, index) => make('input', { type: 'number', step: 'any', id: index ? `${path} ${index}` : path }));
    const row = this.frame(path, what, make('div', { className: 'parts' }, ...boxes));
    const changed = () => this.change(path, boxes.every((box) => box.value === '') ? null : boxes.map((box) => (box.value === '' ? 0 : box.valueAsNumber)));
    boxes.forEach((box, index) => {
      box.setAttribute('aria-label', `${path} ${index + 1}`);
      box.addEventListener('change', changed);
    });
    this.fields.set(path, {
      row,
      show: (found) => boxes.forEach((box, index) => {
        fill(box, found?.[index], row);
      }),
    });
    return row;
  }

  choiceField(names, path, what, meant) {
    const choice = make('select', { id: path, className: 'wide' }, make('option', { value: '', textContent: 'left out' }), ...names.map((name) => make('option', { value: name, textContent: name })));
    choice.addEventListener('change', () => this.change(path, choice.value === '' ? null : meant(choice.value)));
    const row = this.frame(path, what, choice);
    this.fields.set(path, { row, show: (found) => { choice.value = found === undefined ? '' : String(found); } });
    return row;
  }

  textField() {
    const text = make('textarea', { spellcheck: false });
    text.setAttribute('aria-label', 'The whole text of the scene');
    this.textNote = make('div');
    text.addEventListener('change', () => this.onText(text.value, Number(text.dataset.of)));
    return text;
  }

  // A change of one value, with what is wrong about it beside its field.
  change(path, value, gesture) {
    return this.changeAll({ [path]: value }, path, gesture);
  }

  // Of several values, told at the field `path`.
  async changeAll(values, path, gesture) {
    this.right(path);
    try {
      await this.set(values, gesture);
    } catch (error) {
      const key = [...this.fields.keys()].filter((known) => error.key === known || error.key?.startsWith(`${known}.`)).sort((a, b) => b.length - a.length)[0];
      this.wrong(this.fields.has(path) ? path : key, error.message);
      if (key && key !== path && !path.startsWith(`${key}.`)) this.wrong(key, error.message);
    }
  }

  right(path) {
    const field = this.fields.get(path);
    if (!field) return;
    delete field.refusedFor;
    field.row.classList.remove('is-wrong');
    field.row.querySelector(':scope > .wrong')?.remove();
  }

  wrong(path, message) {
    const field = this.fields.get(path);
    if (!field) return;
    this.right(path);
    field.refusedFor = spelled(at(this.scene.values, path));
    const { row } = field;
    row.classList.add('is-wrong');
    row.append(make('div', { className: 'wrong', role: 'alert', textContent: message }));
  }

  // What the plan warns of, and what it decided: on, off or by itself, with what each effect changes at most.
  showPlan(plan) {
    const shown = JSON.stringify([plan, this.asked]);
    if (!plan?.effects || this.shownPlan === shown) return;
    this.shownPlan = shown;
    warnings.replaceChildren(...plan.warnings.map((text) => make('li', { textContent: text })));
    const asked = (it) => this.asked[it.effect] ?? 'auto';
    const told = plan.effects.filter((it) => it.on || it.most_of_white > 0 || asked(it) !== 'auto');
    told.sort((a, b) => Number(b.is_left_out) - Number(a.is_left_out));
    const rows = told.map((it) => {
      const path = `effects.${it.effect}`;
      const choice = make('select', { id: path }, ...['auto', 'on', 'off'].map((name) => make('option', { value: name, textContent: name })));
      choice.value = asked(it);
      choice.addEventListener('change', () => this.change(path, choice.value === 'auto' ? null : choice.value));
      const most = it.most_of_white >= 1e-4 ? `${(100 * it.most_of_white).toPrecision(2)} % of white at most` : 'next to nothing';
      const button = make('button', { textContent: it.on ? 'Off' : 'On', title: it.on ? 'Turn it off' : 'Turn it on' });
      button.addEventListener('click', () => this.change(path, it.on ? 'off' : 'on'));
      const name = make('label', { htmlFor: path, textContent: `${it.on ? '●' : '○'} ${it.effect.replaceAll('_', ' ')}`, title: it.reason });
      const row = make('div', { className: 'effect' }, name, button, choice, make('div', { className: 'says', textContent: it.is_left_out ? `left out: ${most}` : most }));
      this.fields.set(path, { row, show: () => {} });
      return row;
    });
    const nLeftOut = told.filter((it) => it.is_left_out && it.most_of_white > 0).length;
    this.effects.firstChild.textContent = nLeftOut ? `effects (${nLeftOut} left out)` : 'effects';
    this.effects.replaceChildren(this.effects.firstChild, ...rows);
  }
}

// A value, to be held against another one.
function spelled(value) {
  return JSON.stringify(value) ?? 'left out';
}

function plain(row) {
  return { row, show: () => {} };
}

function at(values, path) {
  return path.split('.').reduce((inner, key) => inner?.[key], values);
}
