/** What a project has of what it needs to run, each that lacks with a button that adds it; a world from above, and what its camera sees. */
import { type JSX, type KeyboardEvent, lazy, type PointerEvent, Suspense, useEffect, useMemo, useRef, useState } from "react";

import { nameOf, partsOf, sceneOf, type Thing, thingsOf } from "../../model/parts";
import { server } from "../../protocol/client";
import type { SetupView } from "../../protocol/generated";
import { added, chooseRobot, useBegin } from "../../store/begin";
import { loadGeometry, useRobot } from "../../store/live";
import { isDirty, saveSetup, setValue, useSetup } from "../../store/setup";
import { useProject } from "../../store/tasks";
import type { Dragging } from "../robot/drag";

/** Of `grip.yaml` as it is shown, or else as it is saved. */
export function ProjectParts(): JSX.Element | null {
  const open = useSetup((s) => (s.view?.path === "grip.yaml" ? s.view : null));
  const project = useProject((s) => s.project);
  const [saved, setSaved] = useState<SetupView | null>(null);
  const busy = useBegin((s) => s.busy);
  const error = useBegin((s) => s.error);
  const made = useBegin((s) => s.made);
  useEffect(() => {
    if (open === null) void server.setupFile("grip.yaml").then(setSaved, () => setSaved(null));
  }, [open, project]);
  const file = open ?? saved;
  if (file === null) return null;
  const parts = partsOf(file.data, project?.tasks.map((task) => task.path) ?? []);
  const robot = parts.some((part) => part.what === "robot" && part.names.length > 0);
  return (
    <div className="parts">
      <ul className="plain" aria-label="What the project has">
        {parts.map((part) => (
          <li key={part.what} className={part.names.length > 0 ? "phase-success" : "phase-interrupted"}>
            <span aria-hidden="true">{part.names.length > 0 ? "✓" : "○"}</span> <strong>{part.title}</strong>{" "}
            <span className="part-names">{part.names.length > 0 ? part.names.join(", ") : "none yet"}</span>{" "}
            {part.names.length > 0 ? (
              part.what === "robot" && <button onClick={chooseRobot}>Take another ...</button>
            ) : part.what === "robot" ? (
              <button onClick={chooseRobot}>Choose a robot ...</button>
            ) : (
              robot && (
                <button disabled={busy !== ""} aria-label={`Add ${part.title.toLowerCase()}`} onClick={() => void added(part.what)}>
                  Add
                </button>
              )
            )}
          </li>
        ))}
      </ul>
      {busy && <p className="hint" role="status">{busy}</p>}
      {error && <p className="fault" role="alert">{error}</p>}
      {made !== null && made.files.length === 0 && <p className="hint">The robot's files tell nothing more; what lacks is named in the project's form.</p>}
    </div>
  );
}

/** What a camera of the world sees when everything has settled; drawn by the simulator, of the file as it is saved. */
export function WorldPicture({ name, cameras }: { name: string; cameras: readonly string[] }): JSX.Element {
  const [camera, setCamera] = useState("");
  const [picture, setPicture] = useState("");
  const [said, setSaid] = useState("");
  async function look(): Promise<void> {
    if (isDirty() && !(await saveSetup())) return;
    setSaid("The simulator lets everything settle ...");
    try {
      setPicture(await server.picture(name, camera));
      setSaid("");
    } catch (error) {
      setSaid(error instanceof Error ? error.message : String(error));
    }
  }
  const seen = camera || cameras.at(-1) || "";
  return (
    <section className="world-picture" aria-label="What the camera sees">
      <p>
        {cameras.length > 1 && (
          <select aria-label="Camera" value={seen} onChange={(event) => setCamera(event.target.value)}>
            {cameras.map((each) => (
              <option key={each}>{each}</option>
            ))}
          </select>
        )}{" "}
        <button disabled={cameras.length === 0} onClick={() => void look()}>
          {cameras.length === 0 ? "No camera to look through" : `See what ${seen} sees`}
        </button>
      </p>
      <p role="status" className="hint">{said}</p>
      {picture && <img src={picture} alt={`What the camera ${seen} of the world ${name} sees, after everything has settled`} />}
    </section>
  );
}

const RobotPreview = lazy(() => import("../robot/RobotPreview"));

const MARGIN = 0.12;
const GRID = 0.1;
const ARROWS: Readonly<Record<string, readonly [number, number]>> = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] };
const rounded = (length: number): number => Number((Math.round(length / 0.005) * 0.005).toFixed(3));

/** A world, from above and in 3D with the project's robot: what is dragged in one of them moves in both, and its file has the place when it is dropped. */
export function World({ data }: { data: unknown }): JSX.Element {
  const known = useMemo(() => thingsOf(data), [data]);
  const [held, setHeld] = useState<Thing | null>(null);
  const things = useMemo(() => known.map((thing) => (held !== null && nameOf(thing) === nameOf(held) ? held : thing)), [known, held]);
  const shown = useRef(things);
  shown.current = things;
  const drags = useMemo((): Dragging => {
    let taken: Thing | undefined;
    let moved: Thing | undefined;
    return {
      take: (name) => {
        taken = shown.current.find((thing) => nameOf(thing) === name);
        moved = undefined;
      },
      drag: (by) => {
        if (taken === undefined) return;
        const [x, y, z] = taken.at.map((each, axis) => (by[axis] ? rounded(each + by[axis]) : each)) as [number, number, number];
        moved = { ...taken, at: [x, y, z] };
        setHeld(moved);
      },
      drop: () => {
        const dropped = moved;
        if (taken === undefined || dropped === undefined) return;
        taken = undefined;
        // It stays where it was dropped until the file says so.
        void setValue([dropped.kind, dropped.name, "at"], [...dropped.at]).then(() => setHeld((still) => (still === dropped ? null : still)));
      },
      back: () => {
        taken = undefined;
        setHeld(null);
      },
    };
  }, []);
  return (
    <>
      {known.length > 0 && <WorldPlan known={known} things={things} drags={drags} />}
      <WorldSpace things={things} held={held} drags={drags} />
    </>
  );
}

/** A world in 3D, as its file says it, with the project's robot. */
function WorldSpace({ things, held, drags }: { things: readonly Thing[]; held: Thing | null; drags: Dragging }): JSX.Element {
  const view = useRobot((s) => s.view);
  const scene = useMemo(() => sceneOf(things), [things]);
  useEffect(() => void loadGeometry(), []);
  return (
    <figure className="world-plan">
      <div className="world-space">
        <Suspense fallback={<p className="hint loading">Loading the 3D view ...</p>}>
          <RobotPreview view={view} scene={scene} drags={drags} />
        </Suspense>
      </div>
      <figcaption className="hint">{held ? `${nameOf(held)} at ${held.at.join(", ")} m` : "Drag what stands there, with Shift up and down; Esc takes it back. Drag anything else to look from elsewhere."}</figcaption>
    </figure>
  );
}

/** A world from above, the robot looking up: what stands in it is moved by mouse, or with arrow keys by a centimetre. */
function WorldPlan({ known, things, drags }: { known: readonly Thing[]; things: readonly Thing[]; drags: Dragging }): JSX.Element {
  const plan = useRef<SVGSVGElement>(null);
  const from = useRef<readonly [number, number] | null>(null);
  // The plan stays as large while something is dragged out of it.
  const reach = known.flatMap(({ at: [x, y], size: [a, b] }) => [[x - a / 2, y - b / 2], [x + a / 2, y + b / 2]] as const);
  const [far, near] = [Math.max(0.1, ...reach.map(([x]) => x)) + MARGIN, Math.min(-0.1, ...reach.map(([x]) => x)) - MARGIN];
  const [left, right] = [Math.max(0.1, ...reach.map(([, y]) => y)) + MARGIN, Math.min(-0.1, ...reach.map(([, y]) => y)) - MARGIN];
  function pointed(event: PointerEvent): readonly [number, number] {
    const box = plan.current?.getBoundingClientRect() ?? new DOMRect(0, 0, 1, 1);
    const scale = Math.max((left - right) / box.width, (far - near) / box.height);
    return [-event.clientY * scale, -event.clientX * scale];
  }
  function end(how: "drop" | "back"): void {
    if (from.current !== null) drags[how]();
    from.current = null;
  }
  const lines = (from: number, to: number): number[] => Array.from({ length: Math.floor(to / GRID) - Math.ceil(from / GRID) + 1 }, (_, number) => (Math.ceil(from / GRID) + number) * GRID);
  return (
    <figure className="world-plan">
      <svg ref={plan} role="group" aria-label="The world from above" viewBox={`${-left} ${-far} ${left - right} ${far - near}`}>
        <path className="plan-grid" d={[...lines(near, far).map((x) => `M${-left} ${-x}H${-right}`), ...lines(right, left).map((y) => `M${-y} ${-far}V${-near}`)].join("")} />
        <path className="plan-robot" d="M0 -0.09V0.06M-0.06 0H0.06M0 -0.09l-0.025 0.03M0 -0.09l0.025 0.03" />
        {things.map((thing) => {
          const { kind, name, round, size, yaw, at: [x, y] } = thing;
          return (
            <g
              key={`${kind}/${name}`}
              className={`plan-thing plan-${kind}`}
              role="button"
              tabIndex={0}
              aria-label={`${name} at ${x.toFixed(2)}, ${y.toFixed(2)} m: arrow keys move it`}
              transform={`translate(${-y} ${-x})`}
              onPointerDown={(event) => {
                event.currentTarget.setPointerCapture(event.pointerId);
                from.current = pointed(event);
                drags.take(nameOf(thing));
              }}
              onPointerMove={(event) => {
                if (from.current === null) return;
                const [ahead, aside] = pointed(event);
                drags.drag([ahead - from.current[0], aside - from.current[1], 0]);
              }}
              onPointerUp={() => end("drop")}
              onPointerCancel={() => end("back")}
              onKeyDown={(event: KeyboardEvent) => {
                const step = ARROWS[event.key];
                if (event.key === "Escape") end("back");
                if (!step) return;
                event.preventDefault();
                drags.take(nameOf(thing));
                drags.drag([step[0] / 100, step[1] / 100, 0]);
                drags.drop();
              }}
            >
              {round ? <circle r={size[0] / 2} /> : <rect x={-size[1] / 2} y={-size[0] / 2} width={size[1]} height={size[0]} transform={`rotate(${(-yaw * 180) / Math.PI})`} />}
              <text y={kind === "objects" ? -size[0] / 2 - 0.015 : 0.01}>{name}</text>
            </g>
          );
        })}
      </svg>
      <figcaption className="hint">From above, the robot looks up; 10 cm a square. Drag what stands there; its height and all else are in the form.</figcaption>
    </figure>
  );
}
