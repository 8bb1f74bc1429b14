/** The tree of the task. Statuses reach the nodes through the store, never through the node list. */
import { Background, ControlButton, Controls, type Node, Panel, Position, ReactFlow, type ReactFlowState, useReactFlow, useStore, ViewportPortal } from "@xyflow/react";
import { type JSX, type PointerEvent, type RefObject, useEffect, useMemo, useRef, useState } from "react";

import { type Box, layoutTree } from "../model/layout";
import type { Moment, TaskIndex } from "../model/status";
import { areaInSight, extent, FEW_NODES, hasRoomForMap, isInSight, LINE_AT, linesIn, nearestShown, nodesIn, silhouette, unfolded } from "../model/visibility";
import type { NodeView } from "../protocol/generated";
import { openSubtask } from "../store/converting";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { TreeNode } from "./TreeNode";
import { Detail } from "./marks";

const NODE_TYPES = { task: TreeNode };
const NO_EDGES: never[] = [];
const READABLE_ZOOM = 0.8;
/** Below this a whole tree isn't shown at first: nobody could read it. */
const LEAST_ZOOM = 0.35;

export function TreeCanvas(): JSX.Element {
  const path = useRun((s) => s.task.path);
  const all = useRun((s) => s.task.nodes);
  const closed = usePage((s) => s.closed);
  const shown = useMemo(() => unfolded(all, closed), [all, closed]);
  const boxes = useMemo(() => layoutTree(shown), [shown]);
  const { left, top, right, bottom } = useStore(inSight, sameArea);
  const area = useMemo(() => ({ left, top, right, bottom }), [left, top, right, bottom]);
  const known = useRef(new Map<string, Node>());
  const nodes = useMemo(() => drawn(nodesIn(area, shown, boxes), boxes, known), [area, shown, boxes]);
  const lines = useMemo(() => linesIn(area, shown, boxes), [area, shown, boxes]);
  const mapped = useStore((s) => hasRoomForMap(s.width)) && shown.length > FEW_NODES;
  const [begun, setBegun] = useState("");
  const { select, mark } = usePage.getState();
  const setFollow = usePage((s) => s.setFollow);
  return (
    <ReactFlow
      key={path}
      nodes={nodes}
      edges={NO_EDGES}
      nodeTypes={NODE_TYPES}
      nodesDraggable={false}
      nodesConnectable={false}
      nodesFocusable={false}
      edgesFocusable={false}
      elementsSelectable={false}
      onInit={() => setBegun(path)}
      minZoom={0.1}
      maxZoom={2}
      onNodeClick={(event, node) => (event.ctrlKey || event.metaKey || event.shiftKey ? mark(node.id) : select(node.id))}
      onNodeDoubleClick={(_, node) => {
        const view = all.find((each) => each.path === node.id);
        if (view?.kind === "subtask") return openSubtask(view);
        usePage.getState().enter(node.id);
        usePage.getState().setView("flow");
      }}
      zoomOnDoubleClick={false}
      onMoveStart={(event) => {
        if (event) setFollow(false);
      }}
      attributionPosition="bottom-center"
      aria-label="Tree of the task; the outline has the same content for keyboards"
    >
      <ViewportPortal>
        <svg className="tree-lines" aria-hidden="true">
          <path d={lines} />
        </svg>
      </ViewportPortal>
      <Background gap={24} />
      <Whole key={path} boxes={boxes} begun={begun === path} />
      {mapped && <TreeMap boxes={boxes} />}
      <Detail />
      <Follower boxes={boxes} begun={begun === path} mapped={mapped} />
    </ReactFlow>
  );
}

const inSight = (s: ReactFlowState): ReturnType<typeof areaInSight> => areaInSight(s.transform, s.width, s.height);

function sameArea(one: ReturnType<typeof areaInSight>, other: ReturnType<typeof areaInSight>): boolean {
  return one.left === other.left && one.top === other.top && one.right === other.right && one.bottom === other.bottom;
}

/** The buttons for the zoom. Only nodes in sight are known to the canvas, so that the whole is fitted by its extent. */
function Whole({ boxes, begun }: { boxes: ReadonlyMap<string, Box>; begun: boolean }): JSX.Element {
  const { setViewport } = useReactFlow();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  const fitted = useRef(false);
  const fit = (least: number): void => {
    const { left, top, right, bottom } = extent(boxes.values());
    const zoom = Math.min(1.1, (width * 0.92) / (right - left), (height * 0.92) / (bottom - top));
    if (zoom >= least) return void setViewport({ x: (width - (left + right) * zoom) / 2, y: (height - (top + bottom) * zoom) / 2, zoom });
    // From where it begins, as large as can be read.
    const root = boxes.get("/") as Box;
    void setViewport({ x: 24 - root.x * READABLE_ZOOM, y: height / 2 - (root.y + LINE_AT) * READABLE_ZOOM, zoom: READABLE_ZOOM });
  };
  useEffect(() => {
    if (fitted.current || !begun || width === 0 || boxes.size === 0) return;
    fitted.current = true;
    fit(LEAST_ZOOM);
  });
  return (
    <Controls orientation="horizontal" showInteractive={false} showFitView={false}>
      <ControlButton onClick={() => fit(0.1)} title="Fit View" aria-label="Fit View">
        <svg viewBox="0 0 32 30" aria-hidden="true">
          <path d="M3 9V3h7M22 3h7v6M29 21v6h-7M10 27H3v-6" fill="none" stroke="currentColor" strokeWidth="3" />
        </svg>
      </ControlButton>
    </Controls>
  );
}

/** Keeps the running leaf in sight, and brings a node that was selected elsewhere into sight. */
function Follower({ boxes, begun, mapped }: { boxes: ReadonlyMap<string, Box>; begun: boolean; mapped: boolean }): null {
  const { setCenter, setViewport, getZoom, getViewport } = useReactFlow();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  const follow = usePage((s) => s.follow);
  const selected = usePage((s) => s.selected);
  const running = useRun((s) => (s.cursor === null && s.complete ? null : runningLeaf(s.index, s.moment)));
  const target = follow && running ? nearestShown(running, boxes) : null;
  useEffect(() => {
    const box = target ? boxes.get(target) : undefined;
    const readable = getZoom() >= READABLE_ZOOM;
    if (!box || (readable && isInSight(box, getViewport(), width, height, mapped))) return;
    void setCenter(...centre(box), { zoom: Math.max(getZoom(), READABLE_ZOOM), duration: pace() });
  }, [target, boxes, setCenter, getZoom, getViewport, width, height, mapped]);
  const seen = useRef({ selected, width, height });
  useEffect(() => {
    const box = selected ? boxes.get(selected) : undefined;
    const before = seen.current;
    const resized = begun && (before.width !== width || before.height !== height);
    if (begun) seen.current = { selected, width, height };
    // What is shown at first is found before; then comes the node that was selected in another view. The root, which is
    // selected until something else is, is looked for only when somebody goes to it, or a pane beside this one comes or goes.
    if (!begun || !box || (selected === "/" && before.selected === "/" && !resized)) return;
    // A motion that is under way leads to where the middle was.
    if (resized) void setViewport(getViewport());
    if (isInSight(box, getViewport(), width, height, mapped)) return;
    void setCenter(...centre(box), { zoom: getZoom(), duration: resized ? 0 : pace() });
  }, [selected, boxes, begun, setCenter, setViewport, getZoom, getViewport, width, height, mapped]);
  return null;
}

/** Nodes as the canvas takes them; those that are drawn already stay the same objects, so that nothing of them is done again. */
function drawn(nodes: readonly NodeView[], boxes: ReadonlyMap<string, Box>, known: RefObject<Map<string, Node>>): Node[] {
  const now = nodes.map((node) => {
    const box = boxes.get(node.path) as Box;
    const before = known.current.get(node.path);
    const same = before?.data["node"] === node && before.position.x === box.x && before.position.y === box.y && before.height === box.height;
    return same ? before : canvasNode(node, box);
  });
  known.current = new Map(now.map((node) => [node.id, node]));
  return now;
}

function canvasNode(node: NodeView, { x, y, width, height }: Box): Node {
  const handle = { width: 1, height: 1, y: LINE_AT };
  return {
    id: node.path,
    type: "task",
    position: { x, y },
    data: { node },
    width,
    height,
    measured: { width, height },
    handles: [
      { type: "target", position: Position.Left, x: 0, ...handle },
      { type: "source", position: Position.Right, x: width, ...handle },
    ],
  };
}

function runningLeaf(index: TaskIndex, moment: Moment): string | null {
  let found: string | null = null;
  for (const [path, status] of moment.nodes) {
    if (status.phase === "running" && index.byPath.get(path)?.kind === "leaf") found = path;
  }
  return found;
}

function centre(box: Box): [number, number] {
  return [box.x + box.width / 2, box.y + box.height / 2];
}

function pace(): number {
  return matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 300;
}

const WIDTH = 140;
const HEIGHT = 96;

export function TreeMap({ boxes }: { boxes: ReadonlyMap<string, Box> }): JSX.Element {
  const { setCenter, getZoom } = useReactFlow();
  const all = useMemo(() => extent(boxes.values()), [boxes]);
  const shape = useMemo(() => silhouette(boxes.values()), [boxes]);
  const scale = Math.max((all.right - all.left) / WIDTH, (all.bottom - all.top) / HEIGHT, 1);
  const go = (event: PointerEvent<SVGSVGElement>): void => {
    if (event.buttons !== 1) return;
    const frame = event.currentTarget.getBoundingClientRect();
    const x = (all.left + all.right) / 2 + (event.clientX - frame.left - frame.width / 2) * scale;
    const y = (all.top + all.bottom) / 2 + (event.clientY - frame.top - frame.height / 2) * scale;
    void setCenter(x, y, { zoom: getZoom(), duration: 0 });
  };
  const left = (all.left + all.right - WIDTH * scale) / 2;
  const top = (all.top + all.bottom - HEIGHT * scale) / 2;
  return (
    <Panel position="bottom-right" className="tree-map nopan nowheel">
      <svg
        width={WIDTH}
        height={HEIGHT}
        viewBox={`${left} ${top} ${WIDTH * scale} ${HEIGHT * scale}`}
        aria-hidden="true"
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          go(event);
        }}
        onPointerMove={go}
      >
        <path d={shape} />
        <Frame />
      </svg>
    </Panel>
  );
}

/** What is in sight. */
function Frame(): JSX.Element {
  const [x, y, zoom] = useStore((s) => s.transform);
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  return <rect className="frame" x={-x / zoom} y={-y / zoom} width={width / zoom} height={height / zoom} vectorEffect="non-scaling-stroke" />;
}
