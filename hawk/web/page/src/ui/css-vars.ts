import { nothing } from "lit";
import { Directive, directive, type ElementPart, type PartInfo, PartType } from "lit/directive.js";

/** Sets CSS properties by script: a style attribute is against the page's Content-Security-Policy. */
class CssVars extends Directive {
  constructor(part: PartInfo) {
    super(part);
    if (part.type !== PartType.ELEMENT) throw new Error("cssVars belongs on an element");
  }

  render(_values: Record<string, string>): typeof nothing {
    return nothing;
  }

  override update(part: ElementPart, [values]: [Record<string, string>]): typeof nothing {
    const style = (part.element as HTMLElement | SVGElement).style;
    for (const [name, value] of Object.entries(values)) style.setProperty(name, value);
    return nothing;
  }
}

export const cssVars = directive(CssVars);
