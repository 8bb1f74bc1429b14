/** Long lists: only the rows near the visible part are there. Every row has the same height. */
import { type RefObject, type UIEvent, useEffect, useLayoutEffect, useState } from "react";

export const ROW_HEIGHT = 26;
/** Lists up to this length are there as a whole. */
const WHOLE = 200;
/** Rows beyond what is visible, above and below. */
const SPARE = 30;
/** The window moves in steps, so that scrolling renders seldom. */
const STEP = 10;

export interface Window {
  readonly first: number;
  readonly last: number;
  readonly onScroll: (event: UIEvent) => void;
}

/** Which rows of a scrolling box are to be there; the row `at` is brought into sight whenever it changes. */
export function useWindow(box: RefObject<HTMLElement | null>, count: number, at: number): Window {
  const [top, setTop] = useState(0);
  const [height, setHeight] = useState(600);
  useLayoutEffect(() => {
    if (box.current) setHeight(box.current.clientHeight || 600);
  }, [box, count]);
  useEffect(() => {
    const element = box.current;
    if (!element || at < 0) return;
    const above = at * ROW_HEIGHT;
    if (above < element.scrollTop) element.scrollTop = above;
    else if (above + ROW_HEIGHT > element.scrollTop + element.clientHeight) element.scrollTop = above + ROW_HEIGHT - element.clientHeight;
    setTop(Math.floor(element.scrollTop / ROW_HEIGHT / STEP) * STEP);
  }, [box, at, count]);
  const onScroll = (event: UIEvent): void => setTop(Math.floor(event.currentTarget.scrollTop / ROW_HEIGHT / STEP) * STEP);
  if (count <= WHOLE) return { first: 0, last: count, onScroll };
  const first = Math.max(0, Math.min(top, count) - SPARE);
  return { first, last: Math.min(count, top + Math.ceil(height / ROW_HEIGHT) + SPARE + STEP), onScroll };
}
