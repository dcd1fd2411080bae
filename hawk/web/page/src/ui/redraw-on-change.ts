import type { ReactiveController, ReactiveControllerHost } from "lit";

/** Draws its component again when what it shows reports "change", unless nobody sees it. */
export class RedrawOnChange implements ReactiveController {
  private watched: EventTarget | null = null;
  private connected = false;

  private readonly host: ReactiveControllerHost;
  private readonly model: () => EventTarget;

  constructor(
    host: ReactiveControllerHost,
    model: () => EventTarget,
  ) {
    this.host = host;
    this.model = model;
    host.addController(this);
  }

  hostConnected(): void {
    this.connected = true;
    document.addEventListener("visibilitychange", this.update);
    this.host.requestUpdate();
  }

  /** An update that was asked for before it was disconnected still comes: it must not be kept by the model then. */
  hostUpdate(): void {
    if (!this.connected) return;
    const model = this.model();
    if (model === this.watched) return;
    this.watched?.removeEventListener("change", this.update);
    this.watched = model;
    model.addEventListener("change", this.update);
  }

  hostDisconnected(): void {
    this.connected = false;
    document.removeEventListener("visibilitychange", this.update);
    this.watched?.removeEventListener("change", this.update);
    this.watched = null;
  }

  private readonly update = (): void => {
    if (document.hidden) return;
    this.host.requestUpdate();
  };
}
