/** What the tree and the flow chart share: what is in sight, the zoom's buttons, the map; and the sketch that stands for boxes too small to be read. */
import { ControlButton, Controls, Panel, type ReactFlowState, useReactFlow, useStore, useStoreApi, type Viewport } from "@xyflow/react";
import { type JSX, type PointerEvent, useEffect, useLayoutEffect, useMemo, useRef, useState } from "react";

import type { Box } from "../model/layout";
import { type Area, areaInSight, extent, FAR, FEW, idsIn, MANY } from "../model/visibility";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { useDark } from "./hooks";

/** Below this zoom nodes show nothing that could be read, */
const NAMED = 0.3;
/** and from this on what they are set to. */
const NEAR = 1.5;

export const isNear = (s: ReactFlowState): boolean => s.transform[2] >= NEAR;
const isFar = (s: ReactFlowState): boolean => s.transform[2] < FAR;
/** So many boxes are elements at most: the less can be read of them, the fewer. */
const mostElements = ({ transform: [, , zoom] }: ReactFlowState): number => (zoom < NAMED ? FEW : zoom < FAR ? MANY : Infinity);
const areaOf = (s: ReactFlowState): Area => areaInSight(s.transform, s.width, s.height, s.paneDragging);

/** Whether the drawing is being dragged, and has moved for it: a press alone is no motion. */
function useMoving(): boolean {
  const held = useStore((s) => s.paneDragging);
  const { getState } = useStoreApi();
  const from = useRef<ReactFlowState["transform"] | null>(null);
  if (!held) from.current = null;
  else from.current ??= getState().transform;
  return useStore((s) => s.paneDragging && from.current !== null && s.transform.some((each, at) => each !== from.current?.[at]));
}
const sameArea = (one: Area, other: Area): boolean => one.left === other.left && one.top === other.top && one.right === other.right && one.bottom === other.bottom;

export interface Sight {
  readonly area: Area;
  /** What touches the area, in the order of the boxes. */
  readonly inside: ReadonlySet<string>;
  /** Whether that is so much, and so small or in motion, that it is drawn as a sketch, and only `real` are elements of the page. */
  readonly sketched: boolean;
  /** Whether smaller print than names can't be read. */
  readonly far: boolean;
  /** What is selected, and what something is dragged over: it can be dropped there. */
  readonly real: ReadonlySet<string>;
  /** What the style sheet has to know: elements over a sketch leave the pointer to it, so that a drag moves the drawing. */
  readonly look: string;
  /** What is sketched, or open, at a place of the screen where no element takes the pointer. */
  at(event: { clientX: number; clientY: number }): string | null;
  /** Something is dragged here, or isn't any more. */
  dragged(event: { clientX: number; clientY: number } | null): void;
}

export function useSight(boxes: ReadonlyMap<string, Box>): Sight {
  const { screenToFlowPosition } = useReactFlow();
  const { left, top, right, bottom } = useStore(areaOf, sameArea);
  const area = useMemo(() => ({ left, top, right, bottom }), [left, top, right, bottom]);
  const inside = useMemo(() => idsIn(area, boxes), [area, boxes]);
  const most = useStore(mostElements);
  const moving = useMoving();
  const sketched = inside.size > most || (moving && boxes.size > MANY);
  const selected = usePage((s) => s.selected);
  const [pointed, setPointed] = useState<string | null>(null);
  const real = useMemo(() => new Set([selected, pointed].filter((id) => id !== null && inside.has(id)) as string[]), [selected, pointed, inside]);
  const at: Sight["at"] = ({ clientX, clientY }) => {
    const { x, y } = screenToFlowPosition({ x: clientX, y: clientY });
    let found: string | null = null;
    for (const id of inside) {
      const box = boxes.get(id) as Box;
      // The last one: what stands in a box comes after it.
      if (x >= box.x && x <= box.x + box.width && y >= box.y && y <= box.y + box.height) found = id;
    }
    return found;
  };
  const look = !sketched ? "" : pointed === null ? "sketched" : "sketched over";
  const far = useStore(isFar);
  return { area, inside, sketched, far, real, look, at, dragged: (event) => setPointed(event && at(event)) };
}

/** Tells the style sheet how much nodes show. */
export function Detail(): null {
  const far = useStore(isFar);
  const root = useStore((s) => s.domNode);
  useEffect(() => {
    root?.classList.toggle("far", far);
  }, [root, far]);
  return null;
}

/** Lines that look alike, as one path. */
export interface Stroke {
  readonly path: string;
  /** A variable of the style sheet. */
  readonly color: string;
  readonly width: number;
  readonly dash?: readonly number[];
  readonly filled?: boolean;
}

/** How a box is sketched. */
export interface Face {
  readonly name: string;
  readonly shape: "leaf" | "container" | "open" | "end" | "start";
  /** Of an end. */
  readonly meaning?: string | undefined;
  /** What stands below the name, where it can be read. */
  readonly lines?: readonly string[];
  /** What the outcomes at its right border mean. */
  readonly ports?: readonly string[];
}

/** Words at a place of the drawing, in a variable of the style sheet. */
export interface Label {
  readonly text: string;
  readonly at: { readonly x: number; readonly y: number };
  readonly color: string;
}

interface SketchProps {
  readonly sight: Sight;
  readonly boxes: ReadonlyMap<string, Box>;
  readonly strokes: readonly Stroke[];
  readonly faceOf: (id: string) => Face | undefined;
  readonly labels?: readonly Label[];
}

const NO_LABELS: readonly Label[] = [];

/** A box is sketched at least so wide [px]: of a long flat tree nothing else would be seen. */
const LEAST = 6;
/** So many dots has a sketch in a row or a column at most. */
const MOST_DOTS = 4096;

/**
 * The lines, and where boxes are sketched those too, as one picture of the area. It moves with the drawing: it is made
 * anew only when another area comes into sight, when the zoom changes, or what it shows.
 */
export function Sketch({ sight: { area, inside, sketched, real }, boxes, strokes, faceOf, labels = NO_LABELS }: SketchProps): JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null);
  const zoom = useStore((s) => s.transform[2]);
  const phases = useRun((s) => (sketched ? s.moment.nodes : null));
  const worst = useRun((s) => s.index.worst);
  const version = useRun((s) => (sketched ? s.version : 0));
  const marked = usePage((s) => (sketched ? s.marked : null));
  const dark = useDark();
  const [width, height] = [area.right - area.left, area.bottom - area.top];
  useLayoutEffect(() => {
    const pen = canvas.current?.getContext("2d");
    if (!canvas.current || !pen || !(width > 0)) return;
    const scale = Math.min(zoom * devicePixelRatio, MOST_DOTS / width, MOST_DOTS / height);
    canvas.current.width = Math.ceil(width * scale);
    canvas.current.height = Math.ceil(height * scale);
    pen.setTransform(scale, 0, 0, scale, -area.left * scale, -area.top * scale);
    const look = getComputedStyle(canvas.current);
    const known = new Map<string, string>();
    const color = (name: string): string => {
      const value = known.get(name) ?? look.getPropertyValue(`--${name}`).trim();
      known.set(name, value);
      return value;
    };
    // What can be read is as it is at rest: a motion that begins or ends changes little.
    const near = zoom >= FAR;
    const line = near ? 1 : 1 / zoom;
    if (!sketched) {
      // What is open would hide the lines in it: the ground of its element is drawn here.
      pen.fillStyle = color("sunken");
      for (const id of strokes.length > 0 ? inside : []) {
        const { x, y, width, height } = boxes.get(id) as Box;
        if (faceOf(id)?.shape === "open") pen.fillRect(x, y, width, height);
      }
      for (const stroke of strokes) draw(pen, stroke, color, 1);
      return;
    }
    const box = (id: string, fill: string, border: string, wide: number): void => {
      const { x, y, width: own, height } = boxes.get(id) as Box;
      const width = Math.max(own, LEAST * line);
      if (near) {
        pen.beginPath();
        pen.roundRect(x + wide / 2, y + wide / 2, width - wide, height - wide, 7);
        pen.fillStyle = color(fill);
        pen.fill();
        pen.strokeStyle = color(border);
        pen.lineWidth = wide;
        pen.stroke();
        return;
      }
      pen.fillStyle = color(border);
      pen.fillRect(x, y, width, height);
      if (height * zoom < 4 * wide) return;
      pen.fillStyle = color(fill);
      pen.fillRect(x + wide * line, y + wide * line, width - 2 * wide * line, height - 2 * wide * line);
    };
    const faces = [...inside].map((id) => [id, faceOf(id), phases?.get(id)?.phase ?? "idle"] as const);
    for (const [id, face] of faces) if (face?.shape === "open") box(id, "sunken", "line-strong", 1);
    // From very far lines are many to a dot: they grow thin, and boxes stay in sight.
    for (const stroke of strokes) draw(pen, stroke, color, near ? 1 : line * Math.min(1, zoom / NAMED));
    // Where several lie on one dot, what has happened is seen.
    for (const [id, face, phase] of [...faces.filter(([, , phase]) => phase === "idle"), ...faces.filter(([, , phase]) => phase !== "idle")]) {
      if (face === undefined || face.shape === "open") continue;
      const told = face.shape === "end" ? (face.meaning ?? "") : phase;
      if (face.shape === "start") box(id, "text", "text", 1);
      else if (told in PHASES) box(id, `${told}-soft`, told, 2);
      else box(id, face.shape === "leaf" ? "surface" : "sunken", "line-strong", 1);
      const { x, y, width, height } = boxes.get(id) as Box;
      const fault = worst.get(id);
      if (fault) {
        const side = Math.min(6 * line, height / 2);
        pen.fillStyle = color(fault === "error" ? "error" : "warn");
        pen.fillRect(x + width - side, y, side, side);
      }
    }
    pen.strokeStyle = color("accent");
    pen.lineWidth = 2 * line;
    for (const id of marked ?? []) {
      const at = inside.has(id) ? boxes.get(id) : undefined;
      if (at) pen.strokeRect(at.x - 3 * line, at.y - 3 * line, at.width + 6 * line, at.height + 6 * line);
    }
    if (near) {
      for (const [id, face] of faces) if (face && !real.has(id)) write(pen, face, boxes.get(id) as Box, color, look.fontFamily);
      for (const label of labels) tell(pen, label, color, look.fontFamily);
      return;
    }
    if (zoom < NAMED) return;
    pen.font = `600 22px ${look.fontFamily}`;
    pen.textBaseline = "middle";
    pen.fillStyle = color("text");
    for (const [id, face] of faces) {
      const { x, y, width, height } = boxes.get(id) as Box;
      if (face) pen.fillText(cut(face.name, width - 24), x + 12, face.shape === "open" ? y + 24 : y + height / 2);
    }
  }, [area, boxes, faceOf, inside, labels, marked, phases, real, sketched, strokes, dark, version, width, height, worst, zoom]);
  return <canvas ref={canvas} className="sketch" aria-hidden="true" style={{ left: area.left, top: area.top, width, height }} />;
}

/** What a box says where it can be read, with the places of what the style sheet makes of an element. */
function write(pen: CanvasRenderingContext2D, { name, shape, meaning, lines = [], ports = [] }: Face, { x, y, width, height }: Box, color: (name: string) => string, family: string): void {
  const put = (text: string, size: number, left: number, middle: number, look: string, weight = 400): void => {
    pen.font = `${weight} ${size}px ${family}`;
    pen.fillStyle = color(look);
    pen.fillText(cut(text, x + width - left - 8, size), left, middle);
  };
  pen.textBaseline = "middle";
  if (shape === "end" || shape === "start") return put(name, 13, x + 12, y + height / 2, meaning || "text", 600);
  pen.strokeStyle = color("quiet");
  pen.lineWidth = 1.6;
  pen.beginPath();
  pen.arc(x + 18, y + 15.5, 5, 0, 2 * Math.PI);
  pen.stroke();
  put(name, 13, x + 33, y + 16, "text", 600);
  lines.forEach((text, at) => put(text, 12, x + 11, y + 35 + 18 * at + (at > 0 ? 5 : 0), "quiet"));
  ports.forEach((meaning, at) => {
    pen.beginPath();
    pen.arc(x + width, y + 23 + 20 * at, 4.2, 0, 2 * Math.PI);
    pen.fillStyle = color("surface");
    pen.fill();
    pen.strokeStyle = color(meaning);
    pen.lineWidth = 1.5;
    pen.stroke();
  });
}

/** The words of a line, on a ground of their own. */
function tell(pen: CanvasRenderingContext2D, { text, at: { x, y }, color: look }: Label, color: (name: string) => string, family: string): void {
  pen.font = `11px ${family}`;
  pen.textBaseline = "middle";
  const wide = pen.measureText(text).width;
  pen.fillStyle = color("surface");
  pen.fillRect(x - wide / 2 - 4, y - 7, wide + 8, 14);
  pen.fillStyle = color(look);
  pen.fillText(text, x - wide / 2, y);
}

const PHASES = { running: 0, success: 0, failure: 0, interrupted: 0, error: 0 };

/** @param line how wide a line of 1 is. */
function draw(pen: CanvasRenderingContext2D, { path, color, width, dash = [], filled = false }: Stroke, colorOf: (name: string) => string, line: number): void {
  const shape = new Path2D(path);
  pen.strokeStyle = pen.fillStyle = colorOf(color);
  pen.lineWidth = width * line;
  pen.setLineDash(dash.map((each) => each * line));
  if (filled) pen.fill(shape);
  else pen.stroke(shape);
  pen.setLineDash([]);
}

/** As many letters as there is room for. */
function cut(text: string, room: number, size = 22): string {
  const most = Math.max(1, Math.floor(room / (0.57 * size)));
  return text.length <= most ? text : `${text.slice(0, most - 1)}…`;
}

/** How far one can go away: until all of a drawing is in sight. */
export function useLeastZoom(boxes: ReadonlyMap<string, Box>): number {
  return useMemo(() => {
    const { left, top, right, bottom } = extent(boxes.values());
    return Math.max(0.0005, Math.min(0.1, 400 / (right - left), 250 / (bottom - top)));
  }, [boxes]);
}

interface WholeProps {
  readonly boxes: ReadonlyMap<string, Box>;
  readonly begun: boolean;
  /** Below this zoom the whole isn't shown at first: nobody could read it. */
  readonly least: number;
  /** What is shown in its place: the beginning. */
  readonly begin: (all: Area, width: number, height: number) => Viewport;
  /** Something is over when this changes: then the whole is shown again. */
  readonly over?: string;
  /** Whether what was in the middle stays there when a pane beside this one comes or goes. */
  readonly middle?: boolean;
}

/** What the buttons for the zoom take below the whole [px]. */
const BUTTONS = 46;

/** The buttons for the zoom. Only what is in sight is known to the canvas, so that the whole is fitted by its extent. */
export function Whole({ boxes, begun, least, begin, over = "", middle = false }: WholeProps): JSX.Element {
  const { setViewport, getViewport } = useReactFlow();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  const put = useRef<(Viewport & { readonly least: number }) | null>(null);
  const fit = (least: number): void => {
    const all = extent(boxes.values());
    const free = height - BUTTONS;
    const zoom = Math.min(1.1, (width * 0.95) / (all.right - all.left), (free * 0.95) / (all.bottom - all.top));
    const whole = { x: (width - (all.left + all.right) * zoom) / 2, y: (free - (all.top + all.bottom) * zoom) / 2, zoom };
    put.current = { ...(zoom < least ? begin(all, width, height) : whole), least };
    void setViewport(put.current);
  };
  const looked = useRef({ over, width, height });
  useEffect(() => {
    if (!begun || width === 0 || boxes.size === 0) return;
    const { current: before } = looked;
    const [now, then] = [getViewport(), put.current];
    // As long as nobody has moved it, it stays fitted.
    const left = then !== null && Math.abs(now.x - then.x) + Math.abs(now.y - then.y) < 1 && now.zoom === then.zoom;
    const resized = before.width !== width || before.height !== height;
    // Who has asked for the whole goes on seeing it in a pane of another size.
    if (then !== null && left && resized) fit(then.least);
    else if (then === null || before.over !== over) fit(least);
    else if (middle && resized && before.width > 0) void setViewport({ x: now.x + (width - before.width) / 2, y: now.y + (height - before.height) / 2, zoom: now.zoom });
    looked.current = { over, width, height };
  });
  return (
    <Controls orientation="horizontal" showInteractive={false} showFitView={false}>
      <ControlButton onClick={() => fit(0)} title="Fit View" aria-label="Fit View">
        <svg viewBox="0 0 32 30" aria-hidden="true">
          <path d="M3 9V3h7M22 3h7v6M29 21v6h-7M10 27H3v-6" fill="none" stroke="currentColor" strokeWidth="3" />
        </svg>
      </ControlButton>
    </Controls>
  );
}

/** The extents of drawings: the store is asked with every step of a motion. */
const EXTENTS = new WeakMap<ReadonlyMap<string, Box>, Area>();

function seesAll({ transform: [x, y, zoom], width, height }: ReactFlowState, boxes: ReadonlyMap<string, Box>): boolean {
  const all = EXTENTS.get(boxes) ?? extent(boxes.values());
  EXTENTS.set(boxes, all);
  return all.left * zoom + x >= 0 && all.top * zoom + y >= 0 && all.right * zoom + x <= width && all.bottom * zoom + y <= height;
}

const WIDTH = 140;
const HEIGHT = 96;
/** However long a drawing is, its other side takes this part of the map at least. */
const LEAST_PART = 0.3;
/** [px] */
const LEAST_FRAME = 4;

/** The whole drawing in the corner, and what of it is in sight. A press goes there. One that is very long is drawn shorter. */
export function Overview({ boxes }: { boxes: ReadonlyMap<string, Box> }): JSX.Element | null {
  const { setCenter, getZoom } = useReactFlow();
  const canvas = useRef<HTMLCanvasElement>(null);
  // Where all is in sight, a map only covers it.
  const small = useStore((s) => seesAll(s, boxes));
  const { left, top, across, down } = useMemo(() => {
    const all = extent(boxes.values());
    const [wide, high] = [Math.max(1, all.right - all.left) / WIDTH, Math.max(1, all.bottom - all.top) / HEIGHT];
    const most = Math.max(wide, high, 1);
    const [across, down] = [wide, high].map((each) => Math.min(most, each / LEAST_PART)) as [number, number];
    return { across, down, left: (all.left + all.right - WIDTH * across) / 2, top: (all.top + all.bottom - HEIGHT * down) / 2 };
  }, [boxes]);
  useLayoutEffect(() => {
    const pen = canvas.current?.getContext("2d");
    if (!canvas.current || !pen) return;
    canvas.current.width = WIDTH * devicePixelRatio;
    canvas.current.height = HEIGHT * devicePixelRatio;
    pen.scale(devicePixelRatio, devicePixelRatio);
    // What is open is seen through.
    pen.fillStyle = "rgb(128 138 148 / 55%)";
    for (const { x, y, width, height } of boxes.values()) pen.fillRect((x - left) / across, (y - top) / down, Math.max(0.7, width / across), Math.max(0.7, height / down));
  }, [boxes, left, top, across, down, small]);
  const go = (event: PointerEvent<HTMLElement>): void => {
    if (event.buttons !== 1) return;
    const frame = event.currentTarget.getBoundingClientRect();
    void setCenter(left + (event.clientX - frame.left) * across, top + (event.clientY - frame.top) * down, { zoom: getZoom(), duration: 0 });
  };
  if (small) return null;
  return (
    <Panel position="bottom-right" className="map nopan nowheel">
      <canvas ref={canvas} aria-hidden="true" />
      <div
        className="map-face"
        style={{ width: WIDTH, height: HEIGHT }}
        aria-hidden="true"
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          go(event);
        }}
        onPointerMove={go}
      >
        <Frame left={left} top={top} across={across} down={down} />
      </div>
    </Panel>
  );
}

/** What is in sight; never so small that it can't be seen. It is moved, not painted anew, with each step of a motion. */
function Frame({ left, top, across, down }: { left: number; top: number; across: number; down: number }): JSX.Element {
  const [x, y, zoom] = useStore((s) => s.transform);
  const width = useStore((s) => s.width) / zoom / across;
  const height = useStore((s) => s.height) / zoom / down;
  const [wide, high] = [Math.max(width, LEAST_FRAME), Math.max(height, LEAST_FRAME)];
  const at = [(-x / zoom - left) / across - (wide - width) / 2, (-y / zoom - top) / down - (high - height) / 2];
  return <span className="frame" style={{ width: wide, height: high, transform: `translate(${at[0]}px, ${at[1]}px)` }} />;
}

/** Dots behind the drawing: they lie in it and move with it, so that a motion paints nothing anew. */
export function Ground({ area: { left, top, right, bottom } }: { area: Area }): JSX.Element {
  return <div className="ground" aria-hidden="true" style={{ left, top, width: right - left, height: bottom - top, backgroundPosition: `${-left}px ${-top}px` }} />;
}
