/** A container's inside as a flow chart: drag from an outcome to where it leads, drag a node to pin it. */
import { type Connection, type Edge, MarkerType, type Node, Position, ReactFlow, useReactFlow, useStore, type Viewport, ViewportPortal } from "@xyflow/react";
import { type DragEvent, type JSX, type MouseEvent, useCallback, useEffect, useMemo, useRef, useState } from "react";
import { parentOf } from "../../model/commands";
import { isStart, LEAD, PORT_HEIGHT, subtitleOf, targetName } from "../../model/flow";
import { chartedIn, type FlowChart, isCharted, pinAt, type PlacedEdge, type PlacedItem, sceneOf } from "../../model/flowChart";
import type { Box, Point } from "../../model/layout";
import { type Area, FEW_NODES, hasRoomForMap, isInSight, MANY, touches } from "../../model/visibility";
import { openSubtask } from "../../store/converting";
import { useDocument } from "../../store/document";
import { pin } from "../../store/editing";
import { beginWith, connect, disconnect } from "../../store/flowing";
import { connectFree } from "../../store/gestures";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { FormBadge } from "../edit/EditBar";
import { drop, isDrag } from "../hooks";
import { Detail, type Face, Ground, type Label, Overview, type Sight, Sketch, type Stroke, useLeastZoom, useSight, Whole } from "../drawing";
import { NewPane } from "../marks";
import { EndNode, FlowEdgeLine, FlowNode, INSIDE, roundedToDot, StartNode } from "./FlowNode";
import { useChart } from "./layouter";

const NODE_TYPES = { node: FlowNode, end: EndNode, start: StartNode };
const EDGE_TYPES = { line: FlowEdgeLine };
/** Zoom at which a chart can be read; and from which on names can, which are large then. */
const READABLE = 0.75;
const NAMED = 0.53;
const NO_PINS: Record<string, number[]> = {};

export function FlowCanvas(): JSX.Element {
  const task = useRun((s) => s.task);
  const index = useRun((s) => s.index);
  const locked = useRun((s) => s.record !== null);
  const container = usePage((s) => s.container);
  useSelectedContainer();
  const pins = useDocument((s) => s.document?.layout.flow) ?? NO_PINS;
  const opened = usePage((s) => s.opened);
  const scene = useMemo(() => sceneOf(task, index.byPath, container, opened), [task, index, container, opened]);
  const shown = useChart(scene, pins, `${task.path}:${container}`);
  return (
    <section className="flow" aria-label="Flow chart" aria-busy={shown?.scene !== scene} onDragOver={allow} onDrop={(event) => drop(event, { parent: container, index: index.byPath.get(container)?.children.length ?? 0 })}>
      {shown ? <Chart key={shown.key} chart={shown.chart} pins={pins} locked={locked} /> : <p className="hint padded">Laying out the chart ...</p>}
    </section>
  );
}

function Chart({ chart, pins, locked }: { chart: FlowChart; pins: Record<string, number[]>; locked: boolean }): JSX.Element {
  const index = useRun((s) => s.index);
  const container = usePage((s) => s.container);
  const { flow, boxes } = chart;
  const [begun, setBegun] = useState(false);
  const [edge, setEdge] = useState<string | null>(null);
  const [dragged, setDragged] = useState<{ id: string; x: number; y: number } | null>(null);
  const sight = useSight(boxes);
  const { area, sketched, far } = sight;
  const found = useMemo(() => foundIn(chart), [chart]);
  const parts = useMemo(() => partsOf(chart, found, sight, dragged?.id ?? null), [chart, found, sight.inside, sight.real, sketched, dragged?.id]);
  const nodes = useMemo(() => flowNodes(parts.items, boxes, dragged, sketched), [parts, boxes, dragged, sketched]);
  const edges = useMemo(() => flowEdges(chart, parts.edges, edge, dragged?.id ?? null), [chart, parts, edge, dragged?.id]);
  const strokes = useMemo(() => strokesOf(chart, new Set(parts.edges), area, sketched && far), [chart, parts, area, sketched, far]);
  const labels = useMemo(() => (sketched && !far ? labelsIn(chart, area) : []), [chart, area, sketched, far]);
  const faceOf = useCallback((id: string): Face | undefined => faceIn(found.known, id), [found]);
  const mapped = useStore((s) => hasRoomForMap(s.width)) && chart.items.length > FEW_NODES;
  const whole = useMemo(() => withLines(chart), [chart]);
  const leastZoom = useLeastZoom(whole);
  const pinned = chart.items.some(({ item }) => pins[item.id] !== undefined);
  useEffect(() => setDragged(null), [chart]);

  const onConnect = useCallback(({ source, sourceHandle, target, targetHandle }: Connection): void => {
    // From inside to the border of its own box: to an end of the container, or from its start.
    const end = targetHandle?.startsWith(INSIDE) ? targetHandle.slice(INSIDE.length) : null;
    const within = sourceHandle === INSIDE ? source : chartedIn(source, container);
    if (isStart(target)) return;
    if (within !== (end === null ? chartedIn(target, container) : target)) {
      useRun.getState().setError("An edge stays within its container: connect it to a sibling or to an end of the container.");
    } else if (isStart(source) || sourceHandle === INSIDE) void beginWith(target);
    else void connect(source, sourceHandle ?? "success", end ?? targetName(target));
  }, [container]);
  const press = (event: MouseEvent, id: string | null): void => {
    setEdge(null);
    if (id === null || !index.byPath.has(id)) return;
    const { select, mark } = usePage.getState();
    (event.ctrlKey || event.metaKey || event.shiftKey ? mark : select)(id);
  };
  const enterAt = (id: string | null): void => {
    const view = index.byPath.get(id ?? "");
    if (view?.kind === "subtask") openSubtask(view);
    else if (view?.children.length) usePage.getState().enter(view.path);
  };
  const chosen = chart.edges.find((each) => each.id === edge);
  const canEdit = !locked;
  return (
    <>
      <div className="flow-strip">
        <Breadcrumbs />
        <FormBadge path={container} />
        {flow.strip && <span>{flow.strip}</span>}
        {flow.machine && canEdit && <button onClick={() => void connectFree(container)}>Connect free outcomes</button>}
        {chosen && canEdit && !isStart(chosen.source) && (
          <span className="edge-tools" role="group" aria-label="Selected edge">
            {targetName(chosen.source)}.{chosen.outcome} → {targetName(chosen.target)}
            <button onClick={() => void disconnect(chosen.source, chosen.outcome, chosen.derived)}>Remove this edge</button>
          </span>
        )}
      </div>
      <ReactFlow
        nodes={nodes}
        edges={edges}
        nodeTypes={NODE_TYPES}
        edgeTypes={EDGE_TYPES}
        nodesDraggable={canEdit}
        nodesConnectable={canEdit}
        nodesFocusable={false}
        edgesFocusable={false}
        elementsSelectable
        deleteKeyCode={null}
        selectionKeyCode={null}
        multiSelectionKeyCode={null}
        className={strokes.length > 0 && !sketched ? "lined" : sight.look}
        minZoom={leastZoom}
        maxZoom={2}
        onInit={() => setBegun(true)}
        onMouseMove={() => sight.dragged(null)}
        onDragOver={sight.dragged}
        onConnect={onConnect}
        onNodeClick={(event, node) => press(event, node.id)}
        onNodeDoubleClick={(_, node) => enterAt(node.id)}
        onDoubleClick={(event) => enterAt(sight.at(event))}
        onEdgeClick={(_, clicked) => setEdge(clicked.id)}
        onPaneClick={(event) => press(event, sight.at(event))}
        onNodeDrag={(_, node) => setDragged({ id: node.id, ...node.position })}
        onNodeDragStop={(_, node) => {
          if (node.type === "node") void pin("flow", { [node.id]: pinAt(chart, node.id, node.position) });
        }}
        attributionPosition="bottom-center"
        aria-label="Flow chart of the container; the outline and the forms have the same content for keyboards"
      >
        <ViewportPortal>
          {!sketched && <Ground area={area} />}
          {(sketched || strokes.length > 0) && <Sketch sight={sight} boxes={boxes} strokes={strokes} faceOf={faceOf} labels={labels} />}
        </ViewportPortal>
        <Whole boxes={whole} begun={begun} least={NAMED} begin={beginning} middle />
        {mapped && <Overview boxes={boxes} />}
        <Detail />
        <Keeper boxes={boxes} begun={begun} mapped={mapped} pinned={pinned} />
      </ReactFlow>
      <Pinned chart={chart} pins={pins} locked={locked} />
    </>
  );
}

/** All that a chart takes: lines go round its boxes. */
function withLines({ boxes, edges }: FlowChart): ReadonlyMap<string, Box> {
  const corners = edges.flatMap(({ id, points }) => points.map(({ x, y }, i) => [`${id}\n${i}`, { x, y, width: 0, height: 0 }] as const));
  return new Map([...boxes, ...corners]);
}

/** Its upper left, as large as can be read. */
function beginning({ left, top, bottom }: Area, _: number, height: number): Viewport {
  return { x: 16 - left * READABLE, y: Math.max(16, (height - (bottom - top) * READABLE) / 2) - top * READABLE, zoom: READABLE };
}

function allow(event: DragEvent): void {
  if (isDrag(event)) event.preventDefault();
}

/** Offers to place pinned nodes automatically again. */
function Pinned({ chart, pins, locked }: { chart: FlowChart; pins: Record<string, number[]>; locked: boolean }): JSX.Element | null {
  const here = chart.items.map(({ item }) => item.id).filter((id) => pins[id] !== undefined);
  if (here.length === 0 || locked) return null;
  return (
    <button className="tidy" onClick={() => void pin("flow", Object.fromEntries(here.map((id) => [id, null])))}>
      Tidy up ({here.length} pinned)
    </button>
  );
}

/** Goes to the container of a node that was selected elsewhere. */
function useSelectedContainer(): void {
  const selected = usePage((s) => s.selected);
  useEffect(() => {
    const { container, enter } = usePage.getState();
    const { byPath } = useRun.getState().index;
    const parent = selected === null ? null : parentOf(selected);
    if (selected === null || selected === container || isCharted(selected, container, usePage.getState().opened) || !byPath.has(selected)) return;
    if (selected === "/" || parent === null) enter("/");
    else enter(parent);
  }, [selected]);
}

/** Brings a node that was selected elsewhere into sight, and keeps what one looks at where it is when the chart is laid out anew. */
function Keeper({ boxes, begun, mapped, pinned }: { boxes: ReadonlyMap<string, Box>; begun: boolean; mapped: boolean; pinned: boolean }): null {
  const selected = usePage((s) => s.selected);
  const { setCenter, setViewport, getZoom, getViewport } = useReactFlow();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  const size = useRef({ width, height });
  useEffect(() => {
    size.current = { width, height };
  }, [width, height]);
  const were = useRef(boxes);
  useEffect(() => {
    const before = were.current;
    were.current = boxes;
    if (!begun || before === boxes || pinned) return;
    const { x, y, zoom } = getViewport();
    const [dx, dy] = shiftOf(before, boxes, usePage.getState().selected, { x: (size.current.width / 2 - x) / zoom, y: (size.current.height / 2 - y) / zoom });
    if (dx !== 0 || dy !== 0) void setViewport({ x: x - dx * zoom, y: y - dy * zoom, zoom });
  }, [boxes, begun, pinned, getViewport, setViewport]);
  useEffect(() => {
    const box = selected === null ? undefined : boxes.get(selected);
    if (!begun || !box || width === 0) return;
    if (!isInSight(box, getViewport(), width, height, mapped)) void setCenter(box.x + box.width / 2, box.y + box.height / 2, { zoom: getZoom(), duration: 0 });
  }, [selected, boxes, begun, width, height, mapped, setCenter, getZoom, getViewport]);
  return null;
}

/** How far what the person looks at has moved: the selected node, or the one in the middle of the pane. It stays where it was on the screen. */
function shiftOf(before: ReadonlyMap<string, Box>, now: ReadonlyMap<string, Box>, selected: string | null, middle: { x: number; y: number }): [number, number] {
  const both = [...before].filter(([id]) => now.has(id));
  const far = ([, box]: [string, Box]): number => Math.hypot(box.x + box.width / 2 - middle.x, box.y + box.height / 2 - middle.y);
  const anchor = both.find(([id]) => id === selected) ?? both.sort((a, b) => far(a) - far(b))[0];
  if (anchor === undefined) return [0, 0];
  const to = now.get(anchor[0]) as Box;
  return [to.x - anchor[1].x, to.y - anchor[1].y];
}

/** The start and the ends of a container that is open are on its border. */
const ownerOf = (id: string, boxes: ReadonlyMap<string, Box>): string => (boxes.has(id) ? id : id.slice(0, id.indexOf("#")));

/** What of a chart is asked for with each part of it that comes into sight. */
interface Found {
  readonly known: ReadonlyMap<string, PlacedItem & { readonly order: number }>;
  /** Edges by what they leave. */
  readonly leaving: ReadonlyMap<string, readonly PlacedEdge[]>;
}

function foundIn({ items, edges, boxes }: FlowChart): Found {
  const leaving = new Map<string, PlacedEdge[]>();
  for (const edge of edges) {
    const owner = ownerOf(edge.source, boxes);
    if (!leaving.get(owner)?.push(edge)) leaving.set(owner, [edge]);
  }
  return { known: new Map(items.map((each, order) => [each.item.id, { ...each, order }])), leaving };
}

interface Parts {
  readonly items: readonly PlacedItem[];
  readonly edges: readonly PlacedEdge[];
}

/**
 * What of a chart is made of elements: all of a small one; of a large one what is in sight, with the edges that leave it
 * there and what they lead to. The other edges are drawn as lines.
 */
function partsOf(chart: FlowChart, { known, leaving }: Found, { inside, real, sketched }: Sight, dragged: string | null): Parts {
  if (!sketched && chart.items.length <= MANY) return chart;
  const ids = new Set(sketched ? real : inside);
  if (dragged !== null) ids.add(dragged);
  const edges = sketched ? [] : [...inside].flatMap((id) => leaving.get(id) ?? []);
  for (const edge of edges) ids.add(ownerOf(edge.target, chart.boxes));
  for (const id of sketched ? [] : [...ids]) for (let at = known.get(id)?.parent ?? null; at !== null; at = known.get(at)?.parent ?? null) ids.add(at);
  const items = [...ids].flatMap((id) => known.get(id) ?? []);
  return { items: items.sort((one, other) => one.order - other.order), edges };
}

/**
 * The edges that touch an area and aren't elements, those that look alike as one path.
 * @param plain whether nobody could see how their corners and heads are.
 */
function strokesOf(chart: FlowChart, elements: ReadonlySet<PlacedEdge>, area: Area, plain: boolean): Stroke[] {
  const lines = new Map<string, string[]>();
  const add = (look: string, path: string): void => {
    if (!lines.get(look)?.push(path)) lines.set(look, [path]);
  };
  for (const edge of elements.size === chart.edges.length ? [] : chart.edges) {
    if (elements.has(edge) || !touches(edge.points, area)) continue;
    const meaning = edge.meaning || "plain";
    const last = edge.points.at(-1) ?? { x: 0, y: 0 };
    add(`${meaning} ${edge.derived ? "2 4" : ""}`, plain ? `M${edge.points.map(({ x, y }) => `${x} ${y}`).join("L")}` : roundedToDot(edge.points));
    if (!plain) add(`${meaning} head`, `M${last.x - 5} ${last.y}l-9 -5v10z`);
  }
  return [...lines].map(([look, paths]) => {
    const [meaning, ...more] = look.trim().split(" ");
    const filled = more[0] === "head";
    return { path: paths.join(""), color: `edge-${meaning}`, width: meaning === "success" ? 1.8 : 1.3, filled, dash: filled ? [] : more.map(Number) };
  });
}

/** The words of the edges that touch an area. */
function labelsIn(chart: FlowChart, area: Area): Label[] {
  return chart.edges.flatMap(({ label, words, points, meaning }) => (label && words && touches(points, area) ? [{ text: label, at: words, color: meaning ? `edge-${meaning}` : "text" }] : []));
}

function faceIn(items: ReadonlyMap<string, PlacedItem>, id: string): Face | undefined {
  const placed = items.get(id);
  if (placed === undefined) return undefined;
  const { kind, node, outcome = "", meaning } = placed.item;
  if (kind !== "node") return { name: outcome, shape: kind, meaning };
  const lines = node ? [subtitleOf(node)] : [];
  return { name: node?.name ?? "", shape: placed.ports !== null ? "open" : node?.kind === "leaf" ? "leaf" : "container", lines, ports: placed.ports === null ? placed.item.ports.map((port) => `edge-${port.meaning || "plain"}`) : [] };
}

/** @param flat whether each stands by itself: where a chart is sketched, what is around a box isn't an element. */
function flowNodes(items: readonly PlacedItem[], boxes: ReadonlyMap<string, Box>, dragged: { id: string; x: number; y: number } | null, flat: boolean): Node[] {
  return items.map(({ item, parent, box, box: { width, height }, ports }) => ({
    id: item.id,
    type: item.kind,
    position: pick(dragged?.id === item.id ? dragged : flat ? (boxes.get(item.id) ?? box) : box),
    data: { item, ports },
    width,
    height,
    measured: { width, height },
    draggable: item.kind === "node" && !flat,
    handles: handlesOf({ item, ports, box }),
    ...(parent === null || flat ? {} : { parentId: parent }),
  }));
}

const pick = ({ x, y }: Point): Point => ({ x, y });

function handlesOf({ item, ports, box: { width, height } }: Pick<PlacedItem, "item" | "ports" | "box">): NonNullable<Node["handles"]> {
  const dot = (type: "source" | "target", id: string, x: number, y: number) => ({ type, id, position: x > 0 ? Position.Right : Position.Left, x: x - 5, y: y - 5, width: 10, height: 10 });
  if (item.kind === "start") return [dot("source", "", width, height / 2)];
  const entry = item.kind === "end" ? height / 2 : (ports?.get("")?.y ?? LEAD);
  const outcomes = item.ports.map((port, i) => [port.outcome, ports?.get(port.outcome)?.y ?? LEAD + i * PORT_HEIGHT] as const);
  const inside = ports === null ? [] : [dot("source", INSIDE, 0, entry), ...outcomes.map(([outcome, y]) => dot("target", INSIDE + outcome, width, y))];
  return [dot("target", "in", 0, entry), ...outcomes.map(([outcome, y]) => dot("source", outcome, width, y)), ...inside];
}

function flowEdges({ boxes }: FlowChart, edges: readonly PlacedEdge[], selected: string | null, dragged: string | null): Edge[] {
  return edges.map((edge) => {
    const [begin, end] = [edge.source, edge.target].map((id) => (boxes.has(id) ? null : ownerOf(id, boxes)));
    return {
      id: edge.id,
      type: "line",
      data: { points: edge.points, words: edge.words, meaning: edge.meaning, free: dragged !== null && [edge.source, edge.target].some((id) => id === dragged || id.startsWith(`${dragged}/`)) },
      source: begin ?? edge.source,
      sourceHandle: begin ? INSIDE : edge.outcome,
      target: end ?? edge.target,
      targetHandle: end ? INSIDE + targetName(edge.target) : "in",
      label: edge.label || undefined,
      selected: edge.id === selected,
      className: `${edge.derived ? "derived" : "stored"} ${edge.meaning}`,
      markerEnd: { type: MarkerType.ArrowClosed, width: 14, height: 14, color: `var(--edge-${edge.meaning || "plain"})` },
      focusable: false,
      interactionWidth: 18,
    };
  });
}

export function Breadcrumbs(): JSX.Element {
  const container = usePage((s) => s.container);
  const index = useRun((s) => s.index);
  const file = useRun((s) => s.task.path);
  const name = useRun((s) => s.task.name);
  const { enter, select } = usePage.getState();
  const chain: string[] = [];
  for (let at: string | null = container; at !== null; at = parentOf(at)) chain.unshift(at);
  return (
    <nav aria-label="Containers">
      <ol className="crumbs">
        {chain.map((path) => (
          <li key={path}>
            <button
              className="link"
              {...(path === container ? { "aria-current": "location" as const } : {})}
              onClick={() => {
                enter(path);
                select(path);
              }}
            >
              {path === "/" ? name : index.byPath.get(path)?.name}
            </button>
          </li>
        ))}
      </ol>
      <NewPane task={file} at={container} words="Open this container in a pane of its own" />
    </nav>
  );
}
