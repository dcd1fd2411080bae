/** True when the first pointing device is a finger: then it is "tap", not "click". */
export function isTouch(): boolean {
  return matchMedia("(pointer: coarse)").matches;
}
