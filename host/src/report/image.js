// The image. Its pixels come as 16-bit codes in the red and green of a PNG: asinh of the value above
// a pivot, from `low` to `high`; 0 stands for an undefined pixel.
const preview = data.preview, CODES = 65535;
const valueOf = code => preview.pivot
  + preview.scale * Math.sinh(preview.low + (code - 1) / (CODES - 1) * (preview.high - preview.low));
const codeOf = value =>
  1 + (Math.asinh((value - preview.pivot) / preview.scale) - preview.low) / (preview.high - preview.low || 1) * (CODES - 1);

// From a value between black and white to a shade between 0 and 1.
const CURVES = {
  asinh: (part, span) => Math.asinh(part * span / preview.scale) / Math.asinh(span / preview.scale),
  linear: part => part,
  "square root": part => Math.sqrt(part),
  logarithm: part => Math.log1p(1000 * part) / Math.log(1001),
};
const picture = $("picture"), pen = picture.getContext("2d");
let codes = null;
const stretch = () => {
  if (!codes) return;
  const black = valueOf(Number($("black").value)), white = valueOf(Number($("white").value));
  const span = Math.max(white - black, Number.MIN_VALUE), curve = CURVES[$("curve").value];
  const inverted = $("invert").getAttribute("aria-pressed") === "true";
  const shades = Uint8Array.from({ length: CODES + 1 }, (_, code) => {
    const shade = code === 0 ? 0 : Math.round(255 * curve(clamp((valueOf(code) - black) / span, 0, 1), span));
    return inverted ? 255 - shade : shade;
  });
  const image = pen.createImageData(picture.width, picture.height), out = new Uint32Array(image.data.buffer);
  codes.forEach((code, at) => { out[at] = 0xff000000 | shades[code] * 0x010101; });
  pen.putImageData(image, 0, 0);
};
const restretch = soon(stretch);
const codesOf = image => {
  Object.assign(picture, { width: image.naturalWidth, height: image.naturalHeight });
  pen.drawImage(image, 0, 0);
  const bytes = pen.getImageData(0, 0, picture.width, picture.height).data;
  return Uint16Array.from({ length: bytes.length / 4 }, (_, at) => bytes[4 * at] << 8 | bytes[4 * at + 1]);
};
const resetStretch = () => {
  $("curve").value = "asinh";
  $("black").value = clamp(codeOf(preview.black), 1, CODES);
  $("white").value = clamp(codeOf(preview.white), 1, CODES);
  restretch();
};
Object.keys(CURVES).forEach(name => $("curve").append(make("option", {}, name)));
["black", "white"].forEach(name => Object.assign($(name), { min: 1, max: CODES, step: "any" }));
["curve", "black", "white"].forEach(name => $(name).addEventListener("input", restretch));
$("reset").addEventListener("click", resetStretch);
resetStretch();
const ready = (async () => {
  const image = new Image();
  image.src = preview.image;
  await image.decode();
  codes = codesOf(image);
  stretch();
})();

// The view: a window onto the image, in image pixels from its upper left corner.
const sky = $("sky"), { width, height } = data;
const view = { x: 0, y: 0, w: width, h: height };
const watchers = [];
const apply = () => {
  sky.setAttribute("viewBox", `${view.x} ${view.y} ${view.w} ${view.h}`);
  const matrix = sky.getScreenCTM(), frame = sky.getBoundingClientRect();
  if (!matrix || !frame.width) return;
  const [x, y] = [matrix.e - frame.left, matrix.f - frame.top];
  picture.style.transform = `translate(${x}px, ${y}px) scale(${matrix.a * preview.step}, ${matrix.d * preview.step})`;
  watchers.forEach(watcher => watcher());
};
const fit = () => { Object.assign(view, { x: 0, y: 0, w: width, h: height }); apply(); };
const place = event => {
  const point = new DOMPoint(event.clientX, event.clientY);
  return point.matrixTransform(sky.getScreenCTM().inverse());
};
/** Zooms about a point that stays where it is. */
const zoom = (factor, at = { x: view.x + view.w / 2, y: view.y + view.h / 2 }) => {
  const least = 8 / Math.max(width, height);
  const scale = clamp(view.w * factor / width, least, 2) * width / view.w;
  view.x = at.x - (at.x - view.x) * scale;
  view.y = at.y - (at.y - view.y) * scale;
  view.w *= scale;
  view.h *= scale;
  apply();
};
const move = (dx, dy) => { view.x += dx; view.y += dy; apply(); };
/** Shows a box [left, top, right, bottom] with some sky around it. */
const visit = ([left, top, right, bottom]) => {
  const size = Math.min(Math.max(6 * (right - left), 6 * (bottom - top), 40), Math.max(width, height));
  view.w = size * Math.max(1, width / height);
  view.h = view.w * height / width;
  view.x = (left + right - view.w) / 2;
  view.y = (top + bottom - view.h) / 2;
  apply();
};
fit();
new ResizeObserver(apply).observe(sky);

// What is under the pointer: pixel, value, right ascension and declination.
/** The value of a pixel, or the mean of the pixels that share one of the preview. */
const valueAt = ({ x, y }) => {
  const code = codes?.[Math.floor(y / preview.step) * picture.width + Math.floor(x / preview.step)];
  return code ? valueOf(code) : null;
};
/** The direction between the four nearest of the grid, where all of them are on the sky. */
const directionAt = ({ x, y }) => {
  if (!data.sky) return null;
  const { columns, rows, directions } = data.sky;
  const [u, v] = [x / width * (columns - 1), y / height * (rows - 1)];
  const [i, j] = [clamp(Math.floor(u), 0, columns - 2), clamp(Math.floor(v), 0, rows - 2)];
  const corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(([di, dj]) => directions[(j + dj) * columns + i + di]);
  if (corners.some(corner => corner === null)) return null;
  const [p, q] = [u - i, v - j], weights = [(1 - p) * (1 - q), p * (1 - q), (1 - p) * q, p * q];
  return [0, 1, 2].map(axis => corners.reduce((sum, corner, k) => sum + weights[k] * corner[axis], 0));
};
const skyAt = at => {
  const direction = directionAt(at);
  if (!direction) return "";
  const [x, y, z] = direction, degrees = 180 / Math.PI;
  const ra = (Math.atan2(y, x) * degrees + 360) % 360, dec = Math.atan2(z, Math.hypot(x, y)) * degrees;
  return `  ra ${ra.toFixed(5)}  dec ${dec >= 0 ? "+" : ""}${dec.toFixed(5)} ${data.sky.frame}`;
};
const readOut = at => {
  const inside = at.x >= 0 && at.y >= 0 && at.x < width && at.y < height;
  if (!inside) return "";
  const value = valueAt(at), told = value === null ? "undefined" : String(Number(value.toPrecision(4)));
  // FITS: the centre of the lower left pixel is (1, 1).
  return `x ${(at.x + 0.5).toFixed(1)}  y ${(height - at.y + 0.5).toFixed(1)}  ${preview.step > 1 ? "mean" : "value"} ${told}`
    + skyAt(at);
};
