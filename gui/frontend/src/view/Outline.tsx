/** The same tree as an ARIA tree: one tab stop, arrow keys, statuses as text. */
import { type JSX, type KeyboardEvent, useEffect, useMemo, useRef } from "react";
import { kindTitle } from "../model/kinds";
import { statusText } from "../model/words";
import { IDLE } from "../model/status";
import { outlineKey, type Row, visibleRows } from "../model/visibility";
import { selectedBy } from "../model/others";
import { useOthersAt } from "../store/others";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { OtherDots } from "./Presence";
import { ROW_HEIGHT, useDropTarget, useWindow } from "./hooks";
import { KindIcon, PhaseIcon } from "./icons";
import { HoldMark, lensMark, ProblemMark } from "./marks";

export function Outline(): JSX.Element {
  const nodes = useRun((s) => s.task.nodes);
  const closed = usePage((s) => s.closed);
  const selected = usePage((s) => s.selected);
  const { select, setClosed } = usePage.getState();
  const rows = useMemo(() => visibleRows(nodes, closed), [nodes, closed]);
  const focused = rows.some((row) => row.node.path === selected) ? selected : rows[0]?.node.path;
  const list = useRef<HTMLDivElement>(null);
  const { first, last, onScroll } = useWindow(list, rows.length, rows.findIndex((row) => row.node.path === focused));

  function onKeyDown(event: KeyboardEvent): void {
    if (event.altKey || event.ctrlKey || event.metaKey) {
      if (event.key === " " && focused) {
        event.preventDefault();
        usePage.getState().mark(focused);
      }
      return;
    }
    const step = focused === null || focused === undefined ? null : outlineKey(event.key, focused, rows, closed);
    if (!step) return;
    event.preventDefault();
    if ("open" in step) setClosed(step.open, false);
    else if ("close" in step) setClosed(step.close, true);
    else {
      if (event.shiftKey) usePage.getState().markAll([...usePage.getState().marked, step.go]);
      else select(step.go);
      list.current?.querySelector<HTMLElement>(`[data-row="${CSS.escape(step.go)}"]`)?.focus();
    }
  }

  return (
    <section className="panel outline" aria-labelledby="outline-title">
      <h2 id="outline-title">Outline</h2>
      <div className="scroll" role="tree" aria-multiselectable="true" aria-labelledby="outline-title" ref={list} onKeyDown={onKeyDown} onScroll={onScroll}>
        <div role="presentation" style={{ height: first * ROW_HEIGHT }} />
        {rows.slice(first, last).map((row) => (
          <OutlineRow key={row.node.path} row={row} isClosed={closed.has(row.node.path)} isTabStop={row.node.path === focused} />
        ))}
        <div role="presentation" style={{ height: (rows.length - last) * ROW_HEIGHT }} />
      </div>
    </section>
  );
}

function OutlineRow({ row, isClosed, isTabStop }: { row: Row; isClosed: boolean; isTabStop: boolean }): JSX.Element {
  const { node, level, position, siblings } = row;
  const status = useRun((s) => s.moment.nodes.get(node.path) ?? IDLE);
  const selected = usePage((s) => s.marked.has(node.path));
  const focused = usePage((s) => s.selected === node.path);
  const { select, mark, setClosed } = usePage.getState();
  const target = useDropTarget(node.path);
  const box = useRef<HTMLDivElement>(null);
  const pointed = useRef(false);
  // After an edit the row of the selected node is another element: the focus goes along.
  useEffect(() => {
    const tree = box.current?.closest("[role=tree]");
    if (focused && (document.activeElement === document.body || (tree?.contains(document.activeElement) ?? false))) box.current?.focus({ preventScroll: true });
  }, [focused]);
  const isContainer = node.children.length > 0;
  const lens = usePage((s) => s.lens);
  const others = useOthersAt(node.path, isClosed);
  const words = statusText(status);
  return (
    <div
      role="treeitem"
      className={`row is-${status.phase}`}
      data-row={node.path}
      aria-level={level}
      aria-posinset={position}
      aria-setsize={siblings}
      aria-selected={selected}
      {...(others.length > 0 ? { "aria-description": selectedBy(others) } : {})}
      {...(isContainer ? { "aria-expanded": !isClosed } : {})}
      tabIndex={isTabStop ? 0 : -1}
      style={{ paddingInlineStart: `${level * 14 - 6}px` }}
      onClick={(event) => (event.ctrlKey || event.metaKey || event.shiftKey ? mark(node.path) : select(node.path))}
      onPointerDown={() => {
        pointed.current = true;
      }}
      onPointerUp={() => {
        pointed.current = false;
      }}
      onFocus={() => {
        // A press selects by its click, which knows of the keys that are held.
        if (!pointed.current && !usePage.getState().marked.has(node.path)) select(node.path);
        pointed.current = false;
      }}
      ref={box}
      {...target}
    >
      <span
        className={`twisty${isContainer ? (isClosed ? " closed" : " open") : ""}`}
        onClick={(event) => {
          if (!isContainer) return;
          event.stopPropagation();
          setClosed(node.path, !isClosed);
        }}
      />
      <KindIcon kind={node.kind} id={node.label} />
      <span className="row-name">
        {node.name}
        <span className="hidden">{`${kindTitle(node.kind)},`}</span>
      </span>
      <HoldMark path={node.path} />
      <ProblemMark path={node.path} />
      {lensMark(node, lens)}
      <OtherDots others={others} />
      <span className={`row-status phase-${status.phase}`}>
        <span className={status.phase === "idle" ? "hidden" : ""}>{words}</span>
        <PhaseIcon phase={status.phase} />
      </span>
    </div>
  );
}
