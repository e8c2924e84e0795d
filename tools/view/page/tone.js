// From linear light to what a screen takes, as the program writes its PNG:
// w = v for v <= 0.8, w = 1 - 0.2 exp(-(v - 0.8)/0.2) above; sRGB(w); rounded to 0..255.

const SHOULDER = 0.8;

const decoded = (code) => (code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4);
const untoned = (w) => (w <= SHOULDER ? w : SHOULDER - (1 - SHOULDER) * Math.log(1 - (w - SHOULDER) / (1 - SHOULDER)));

const bits = new Uint32Array(1);
const number = new Float32Array(bits.buffer);

// The light from which on a pixel has each code, and the code from which to look on by the upper bits of a number.
function curve(inverse) {
  const from = Float64Array.from({ length: 257 }, (_, code) => (code === 0 ? -Infinity : code > 255 ? Infinity : inverse(decoded((code - 0.5) / 255))));
  const first = new Uint8Array(1 << 15);
  for (let upper = 0, code = 0; upper < first.length; upper += 1) {
    bits[0] = upper << 16;
    while (code < 255 && number[0] >= from[code + 1]) code += 1;
    first[upper] = code;
  }
  return { from, first };
}

// A photograph is shown as it is, without a shoulder.
const CURVES = { light: curve(untoned), photograph: curve((w) => w) };

// The code of a light that is shown `gain` times as bright.
function coder({ from, first }, gain) {
  return (light) => {
    const shown = gain * light;
    if (!(shown > 0)) return 0;
    number[0] = shown;
    let code = first[bits[0] >>> 16];
    while (shown >= from[code + 1]) code += 1;
    while (shown < from[code]) code -= 1;
    return code;
  };
}

// Fills the bytes of a canvas with a picture, which a photograph exposed for itself.
export function develop({ rgb, is_photograph: isPhotograph }, bytes, exposureEv, gains) {
  const [by, scale] = isPhotograph ? [CURVES.photograph, 1] : [CURVES.light, 2 ** exposureEv];
  const code = gains.map((gain) => coder(by, gain * scale));
  for (let from = 0, to = 0; from < rgb.length; from += 3, to += 4) {
    bytes[to] = code[0](rgb[from]);
    bytes[to + 1] = code[1](rgb[from + 1]);
    bytes[to + 2] = code[2](rgb[from + 2]);
    bytes[to + 3] = 255;
  }
}

// Gains of red, green and blue that show the light of a black body [K] as white; 1 at that of D65, which nothing does
// exactly: the gains are relative to its nearest. Chromaticity by Kim et al. (2002), 1667 K to 25000 K.
export function whiteGains(kelvin) {
  const asRgb = (temperature) => {
    const [a, b, c] = [1e3 / temperature, 1e6 / temperature ** 2, 1e9 / temperature ** 3];
    const x = temperature < 4000 ? -0.2661239 * c - 0.2343589 * b + 0.8776956 * a + 0.17991 : -3.0258469 * c + 2.1070379 * b + 0.2226347 * a + 0.24039;
    const y = temperature < 2222 ? -1.1063814 * x ** 3 - 1.3481102 * x ** 2 + 2.18555832 * x - 0.20219683
      : temperature < 4000 ? -0.9549476 * x ** 3 - 1.37418593 * x ** 2 + 2.09137015 * x - 0.16748867
        : 3.081758 * x ** 3 - 5.8733867 * x ** 2 + 3.75112997 * x - 0.37001483;
    const [X, Z] = [x / y, (1 - x - y) / y];
    return [3.2404542 * X - 1.5371385 - 0.4985314 * Z, -0.969266 * X + 1.8760108 + 0.041556 * Z, 0.0556434 * X - 0.2040259 + 1.0572252 * Z];
  };
  if (kelvin === 6504) return [1, 1, 1];
  const [light, usual] = [asRgb(kelvin), asRgb(6504)];
  return light.map((value, channel) => usual[channel] / value);
}
