/** The page's font (styles/font.css), for what is drawn on a canvas. */
export const FONT_FAMILY = '"Source Sans 3", system-ui, sans-serif';
