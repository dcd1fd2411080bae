import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { Operator } from "../state/operator.ts";

/** Draws its component again when the model changes, unless nobody sees it. */
export class Watch implements ReactiveController {
  private watched: Operator | null = null;

  private readonly host: ReactiveControllerHost;
  private readonly model: () => Operator;

  constructor(
    host: ReactiveControllerHost,
    model: () => Operator,
  ) {
    this.host = host;
    this.model = model;
    host.addController(this);
  }

  hostConnected(): void {
    document.addEventListener("visibilitychange", this.update);
    this.host.requestUpdate();
  }

  hostUpdate(): void {
    const model = this.model();
    if (model === this.watched) return;
    this.watched?.removeEventListener("change", this.update);
    this.watched = model;
    model.addEventListener("change", this.update);
  }

  hostDisconnected(): void {
    document.removeEventListener("visibilitychange", this.update);
    this.watched?.removeEventListener("change", this.update);
    this.watched = null;
  }

  private readonly update = (): void => {
    if (document.hidden) return;
    this.host.requestUpdate();
  };
}
