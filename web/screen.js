// The canvas that pictures are shown on, and how many pixels it asks for.

// Above so many, a second look at the same fog costs more than it shows.
const WIDTH_MOST_PX = 3840;
// And more than so many no picture has.
const PIXELS_MOST = 8e6;

export class Screen {
  #canvas;

  /** `onResize()` is called when the canvas has another size or the screen other pixels. */
  constructor(canvas, onResize) {
    this.#canvas = canvas;
    let before = "";
    const look = () => {
      const { width, height } = this.size;
      const now = `${width}×${height}`;
      if (before !== "" && now !== before) onResize();
      before = now;
    };
    new ResizeObserver(look).observe(canvas);
    window.addEventListener("resize", look);
  }

  /** The pixels of the screen that the canvas covers. */
  get size() {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [this.#canvas.clientWidth * ratio, this.#canvas.clientHeight * ratio];
    const scale = Math.min(1, WIDTH_MOST_PX / Math.max(width, height, 1), Math.sqrt(PIXELS_MOST / Math.max(width * height, 1)));
    return { width: Math.max(Math.round(width * scale), 1), height: Math.max(Math.round(height * scale), 1) };
  }

  /** Shows a picture and answers its size. */
  async show(blob) {
    const bitmap = await createImageBitmap(blob);
    const { width, height } = bitmap;
    this.#canvas.width = width;
    this.#canvas.height = height;
    this.#canvas.getContext("2d").drawImage(bitmap, 0, 0);
    bitmap.close();
    return { width, height, bytes: blob.size };
  }

  /** How bright the brightest of a few places of the picture is, from 0 to 255. */
  brightest() {
    const small = new OffscreenCanvas(16, 16);
    const context = small.getContext("2d", { willReadFrequently: true });
    context.drawImage(this.#canvas, 0, 0, 16, 16);
    return context.getImageData(0, 0, 16, 16).data.reduce((most, value, i) => (i % 4 === 3 ? most : Math.max(most, value)), 0);
  }
}
