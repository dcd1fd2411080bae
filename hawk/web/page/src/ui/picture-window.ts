import { language, say } from "../words/say.ts";

/** What this page needs of the browser's Document Picture-in-Picture; few browsers have it, over HTTPS or on localhost. */
export interface PictureWindows {
  /** The one that is open. */
  readonly window?: Window | null;
  requestWindow(options: { width: number; height: number }): Promise<Window>;
}

export function pictureWindows(): PictureWindows | null {
  return (window as { documentPictureInPicture?: PictureWindows }).documentPictureInPicture ?? null;
}

/** Whether nobody looks: the page is hidden, and no small window shows the picture. */
export const isUnseen = (): boolean => document.hidden && !pictureWindows()?.window;

const WIDTH = 480;
const AGE_EVERY_MS = 200;

/**
 * A small window with the live picture, above all others.
 *
 * It shows the picture's age by itself, also while the page is hidden: a plain picture-in-picture video could not, and a
 * frozen one would look live.
 */
export class PictureWindow {
  private readonly window: Window;

  private readonly canvas: HTMLCanvasElement;

  private readonly tag: HTMLElement;

  private readonly age: () => { words: string; old: boolean };

  private constructor(window: Window, age: () => { words: string; old: boolean }) {
    this.window = window;
    this.age = age;
    const page = window.document;
    page.title = say("live-picture");
    page.documentElement.lang = language();
    this.canvas = page.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", say("camera-picture"));
    this.tag = page.createElement("span");
    Object.assign(page.body.style, { margin: "0", background: "#0b0f13", overflow: "hidden" });
    Object.assign(this.canvas.style, { width: "100vw", height: "100vh", objectFit: "contain", display: "block" });
    Object.assign(this.tag.style, {
      position: "fixed",
      left: "8px",
      top: "8px",
      padding: "2px 8px",
      borderRadius: "6px",
      background: "rgb(10 15 20 / 78%)",
      color: "#fff",
      font: "13px/20px system-ui, sans-serif",
    });
    page.body.replaceChildren(this.canvas, this.tag);
  }

  /** `age` gives the picture's; `closed` is called when the window has gone. */
  static async open(
    windows: PictureWindows,
    age: () => { words: string; old: boolean },
    closed: () => void,
  ): Promise<PictureWindow> {
    const window = await windows.requestWindow({ width: WIDTH, height: (WIDTH * 9) / 16 });
    const made = new PictureWindow(window, age);
    const timer = window.setInterval(() => made.showAge(), AGE_EVERY_MS);
    window.addEventListener("pagehide", () => {
      window.clearInterval(timer);
      closed();
    });
    made.showAge();
    return made;
  }

  draw(picture: CanvasImageSource & { width: number; height: number }): void {
    if (this.canvas.width !== picture.width) this.canvas.width = picture.width;
    if (this.canvas.height !== picture.height) this.canvas.height = picture.height;
    this.canvas.getContext("2d")?.drawImage(picture, 0, 0);
  }

  close(): void {
    this.window.close();
  }

  /** Shows the age of the picture. */
  showAge(): void {
    const { words, old } = this.age();
    this.tag.textContent = words;
    this.canvas.style.filter = old ? "grayscale(1) brightness(0.6)" : "";
  }
}
