// Colour maps for all kinds of sight: blue and orange, or purple and green, with lightness that rises from the middle
// to both ends or falls; and a sequence whose lightness only rises. Stops are joined in OKLab (Ottosson 2020).

const STOPS = {
  vorticity: {
    light: ["#08306b", "#2a78c2", "#a9cdea", "#f7f8f9", "#f6c08f", "#d9702a", "#6b2503"],
    dark: ["#d6ecff", "#63b0f5", "#1f5fa8", "#0d1218", "#a34a16", "#f08a3c", "#ffe6c9"],
  },
  speed: {
    light: ["#fbf7ef", "#f3d38c", "#e9965a", "#c2517a", "#71338c", "#211447"],
    dark: ["#0b0d1f", "#35246b", "#8f3a83", "#dd6363", "#f8ab59", "#fdf3c6"],
  },
  // Of the magnitude in space: from the middle of the vorticity's colours.
  swirl: {
    light: ["#f7f8f9", "#c5dcee", "#85b4dc", "#4585bf", "#1d5694", "#08306b"],
    dark: ["#0d1218", "#14355c", "#1f5fa8", "#4a97dc", "#93c8f5", "#e4f2ff"],
  },
  pressure: {
    light: ["#40185f", "#8e5fae", "#d5c0e2", "#f7f8f7", "#b9dfb7", "#4a9a5c", "#0b4a25"],
    dark: ["#f0dcff", "#b183d6", "#5e3a85", "#101214", "#1f6b3a", "#66bd78", "#dcf8dd"],
  },
};

export const FIELDS = ["vorticity", "speed", "pressure"];

const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const gamma = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);

function toLab(hex) {
  const [r, g, b] = [1, 3, 5].map((i) => linear(parseInt(hex.slice(i, i + 2), 16) / 255));
  const [l, m, s] = [
    0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b,
    0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b,
    0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b,
  ].map(Math.cbrt);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

function toBytes([L, a, b]) {
  const [l, m, s] = [
    L + 0.3963377774 * a + 0.2158037573 * b,
    L - 0.1055613458 * a - 0.0638541728 * b,
    L - 0.0894841775 * a - 1.291485548 * b,
  ].map((c) => c ** 3);
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ].map((c) => Math.round(255 * Math.min(Math.max(gamma(c), 0), 1)));
}

/** Return 256 colours of a field as [r, g, b]. */
export function colours(field, dark) {
  const stops = STOPS[field][dark ? "dark" : "light"].map(toLab);
  return Array.from({ length: 256 }, (_, i) => {
    const place = (i / 255) * (stops.length - 1);
    const k = Math.min(Math.floor(place), stops.length - 2);
    return toBytes(stops[k].map((c, j) => c + (place - k) * (stops[k + 1][j] - c)));
  });
}

/** Return the colours as numbers of the pixels of a picture. */
export const packed = (list) => Uint32Array.from(list, ([r, g, b]) => ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0);

/** Return a CSS gradient of the colours. */
export const gradient = (list) =>
  `linear-gradient(to right, ${list.filter((_, i) => i % 15 === 0).map((c) => `rgb(${c})`).join(", ")})`;
