import { svg, type TemplateResult } from "lit";
import { html } from "lit";

const PATHS = {
  person: svg`<circle cx="12" cy="8" r="4"/><path d="M5 20.5v-1a5 5 0 0 1 5-5h4a5 5 0 0 1 5 5v1"/>`,
  menu: svg`<path d="M4 6.5h16M4 12h16M4 17.5h16"/>`,
  plus: svg`<path d="M12 5v14M5 12h14"/>`,
  minus: svg`<path d="M5 12h14"/>`,
  follow: svg`<circle cx="12" cy="12" r="4.5"/><path d="M12 2.5v5M12 16.5v5M2.5 12h5M16.5 12h5"/>`,
  whole: svg`<path d="M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5"/>`,
  swap: svg`<rect x="3" y="5" width="18" height="14" rx="1.5"/><rect x="12.5" y="11.5" width="6" height="4.5" fill="currentColor"/>`,
  full: svg`<path d="M14 4h6v6M20 4l-6.5 6.5M10 20H4v-6M4 20l6.5-6.5"/>`,
  photo: svg`<path d="M3.5 7.5h4l1.5-2.5h6l1.5 2.5h4v11.5h-17z"/><circle cx="12" cy="13" r="3.5"/>`,
  window: svg`<path d="M20 11V5H4v14h6"/><path d="M13 14.5h7.5v5H13z" fill="currentColor"/>`,
  close: svg`<path d="M5.5 5.5l13 13M18.5 5.5l-13 13"/>`,
  check: svg`<path d="M4.5 12.5l5 5L19.5 7"/>`,
  info: svg`<circle cx="12" cy="12" r="9"/><path d="M12 11v5.5M12 7.5v.2"/>`,
  warn: svg`<path d="M12 3.5L22 20.5H2z"/><path d="M12 10v5M12 17.7v.1"/>`,
  cross: svg`<path d="M6 6l12 12M18 6L6 18"/>`,
  right: svg`<path d="M5.5 5.5L12 12l-6.5 6.5M12.5 5.5L19 12l-6.5 6.5"/>`,
  download: svg`<path d="M12 4v11M7 10.5l5 5 5-5M5 20h14"/>`,
  upload: svg`<path d="M12 15V4M7 8.5l5-5 5 5M5 20h14"/>`,
  undo: svg`<path d="M4.5 9.5h10a5 5 0 0 1 0 10H9M8.5 5l-4.5 4.5L8.5 14"/>`,
  redo: svg`<path d="M19.5 9.5h-10a5 5 0 0 0 0 10H15M15.5 5l4.5 4.5-4.5 4.5"/>`,
  pointer: svg`<path d="M6 3.5l12.5 8-5.5 1.3 3 5.7-2.6 1.4-3-5.7L6 18z"/>`,
  box: svg`<path d="M4 8V4h4M11 4h2M16 4h4v4M20 11v2M20 16v4h-4M13 20h-2M8 20H4v-4M4 13v-2"/>`,
  row: svg`<path d="M3 6h18M3 6v12M9 6v12M15 6v12M21 6v12"/>`,
  clear: svg`<path d="M4.5 6.5h15M9.5 6V4h5v2M6.5 6.5l1 13.5h9l1-13.5M10.5 10.5v6M13.5 10.5v6"/>`,
  square: svg`<path d="M5 5h14v14H5z"/>`,
  zone: svg`<path d="M4.5 4.5h15v15h-15zM4.5 12l7.5-7.5M4.5 19.5l15-15M12 19.5l7.5-7.5"/>`,
  kerb: svg`<path d="M4 20V4M9 4h11v16H9zM9 12h11"/>`,
  measure: svg`<path d="M3.5 15.5l12-12 5 5-12 12zM7.5 11.5l2 2M10.5 8.5l3 3M13.5 5.5l2 2"/>`,
  layers: svg`<path d="M12 3.5L21.5 9 12 14.5 2.5 9zM3 13.5l9 5.5 9-5.5"/>`,
  play: svg`<path d="M7 4.5v15l12-7.5z" fill="currentColor"/>`,
  pause: svg`<path d="M8 5v14M16 5v14"/>`,
  down: svg`<path d="M5.5 9l6.5 6.5L18.5 9"/>`,
  chain: svg`<path d="M10 14a4 4 0 0 0 6 .4l3-3a4 4 0 0 0-5.7-5.7l-1.5 1.5M14 10a4 4 0 0 0-6-.4l-3 3a4 4 0 0 0 5.7 5.7l1.5-1.5"/>`,
  copy: svg`<path d="M9 9h11v11H9zM5 15H4V4h11v1"/>`,
  left: svg`<path d="M15 5.5L8.5 12l6.5 6.5"/>`,
  arrow: svg`<path d="M4 12h15M13.5 6.5L19 12l-5.5 5.5"/>`,
  next: svg`<path d="M9 5.5l6.5 6.5L9 18.5"/>`,
  globe: svg`<circle cx="12" cy="12" r="9"/><path d="M3 12h18M12 3c5 5 5 13 0 18M12 3c-5 5-5 13 0 18"/>`,
  help: svg`<circle cx="12" cy="12" r="9"/><path d="M9.2 9.3a2.9 2.9 0 1 1 4 2.7c-.9.4-1.2 1-1.2 2M12 17v.2"/>`,
  link: svg`<path d="M5 12a10 10 0 0 1 14 0M8 15.5a5.5 5.5 0 0 1 8 0M12 19.4v.1"/>`,
};

export type IconName = keyof typeof PATHS;

export function icon(name: IconName): TemplateResult {
  return html`<svg class="icon" viewBox="0 0 24 24" aria-hidden="true">${PATHS[name]}</svg>`;
}

/** A needle that points north in the picture; turned by the property --turn. */
export function needle(label: string): TemplateResult {
  return html`<svg class="needle" viewBox="-10 -10 20 20" role="img" aria-label=${label}>
    <path d="M0 -9L6.5 8 0 4.2 -6.5 8z" fill="currentColor" />
  </svg>`;
}
