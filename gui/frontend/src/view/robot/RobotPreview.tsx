/** A robot before it runs: in 3D, its joints moved by sliders within their limits, its named states, what its files said. */
import { type JSX, type KeyboardEvent, useEffect, useMemo, useRef, useState } from "react";

import type { GeometryView, SceneItem } from "../../protocol/generated";
import type { Stand } from "../../model/timeline";
import { keepState, taskThrough } from "../../store/begin";
import { useDark } from "../hooks";
import type { Dragging } from "./drag";
import { isNear, makeReach } from "./reach";
import { makeSpace, type Space, type Spot } from "./space";

interface PreviewProps {
  readonly view: GeometryView | null;
  /** Whether the joints can be moved. */
  readonly moves?: boolean;
  /** What stands around it. */
  readonly scene?: Readonly<Record<string, SceneItem>>;
  /** Poses that are drawn with their names. */
  readonly places?: readonly Spot[];
  /** Name -> joint -> position [rad or m]: a picture each, and the robot goes where one is pressed. */
  readonly stands?: Readonly<Record<string, Readonly<Record<string, number>>>>;
  /** Told of what is dragged of that; without it nothing can be. */
  readonly drags?: Dragging;
}

const REST: Stand = { t: 0, joints: new Map(), scene: {}, bodies: {}, ways: [], plans: [], touch: new Map(), press: [], hardest: 0 };
const ALONE: Readonly<Record<string, SceneItem>> = {};
const NOWHERE: readonly Spot[] = [];

export default function RobotPreview({ view, moves = false, scene = ALONE, places = NOWHERE, stands, drags }: PreviewProps): JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null);
  const space = useRef<Space | null>(null);
  const [error, setError] = useState("");
  const [ready, setReady] = useState<Space | null>(null);
  const [joints, setJoints] = useState<ReadonlyMap<string, number>>(new Map());
  useEffect(() => setJoints(new Map()), [view?.name]);
  useEffect(() => {
    if (!canvas.current || !view || view.error) return;
    try {
      space.current = makeSpace(canvas.current, view);
      space.current.show({ ...REST, scene }, places, [], false);
      space.current.fit();
      setReady(space.current);
    } catch (why) {
      setError(`This browser cannot draw in 3D: ${why instanceof Error ? why.message : String(why)}`);
    }
    return () => {
      space.current?.close();
      space.current = null;
      setReady(null);
    };
  }, [view?.links]); // a position that is kept is no other shape
  useEffect(() => void (drags && ready?.drags(drags)), [ready, drags]);
  const dark = useDark();
  useEffect(() => space.current?.show({ ...REST, joints, scene }, places, [], false), [view, joints, scene, places, dark]);
  function onKeyDown(event: KeyboardEvent): void {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (turn) space.current?.turn(turn[0] ?? 0, turn[1] ?? 0);
    else if (event.key === "+" || event.key === "-") space.current?.nearer(event.key === "+" ? 0.85 : 1.18);
    else return;
    event.preventDefault();
  }
  const fault = error || view?.error;
  const movable = view === null ? [] : view.joints.filter((joint) => joint.type !== "fixed" && !joint.mimic);
  return (
    <div className={moves ? "preview preview-moves" : "preview"}>
      <div className="robot-canvas">
        {fault ? (
          <p className="fault padded" role="alert">{fault}</p>
        ) : view === null ? (
          <p className="hint loading" role="status">Loading the robot's shape ...</p>
        ) : (
          <canvas ref={canvas} tabIndex={0} role="application" aria-roledescription="3D drawing" aria-label={`${view.name}: ${movable.length} joints. Arrow keys turn it, plus and minus go nearer and away.${drags ? " What stands there is moved in the plan by arrow keys, or in the form by number." : ""}`} onKeyDown={onKeyDown} />
        )}
      </div>
      {stands && view && !view.error && (
        <div className="scroll joints states" tabIndex={0} role="group" aria-label="Named joint states">
          {Object.entries(stands).map(([name, at]) => (
            <button key={name} aria-pressed={joints.size > 0 && Object.entries(at).every(([joint, position]) => joints.get(joint) === position)} onClick={() => setJoints(new Map(Object.entries(at)))}>
              <Stands space={ready} at={at} />
              {name}
            </button>
          ))}
        </div>
      )}
      {moves && view && !view.error && <Joints view={view} space={ready} joints={joints} set={setJoints} />}
    </div>
  );
}

interface JointsProps {
  readonly view: GeometryView;
  /** Draws the pictures of named states. */
  readonly space: Space | null;
  readonly joints: ReadonlyMap<string, number>;
  readonly set: (joints: ReadonlyMap<string, number>) => void;
}

function Joints({ view, space, joints, set }: JointsProps): JSX.Element {
  const known = useMemo(() => new Map(view.joints.map((joint) => [joint.name, joint])), [view]);
  return (
    <div className="scroll joints" tabIndex={0} role="group" aria-label="Joints and named states">
      <button onClick={() => set(new Map())}>All at rest</button>
      {Object.entries(view.grasp).map(([hand, frame]) => frame.group !== "" && <Reach key={hand} view={view} hand={hand} joints={joints} set={set} />)}
      {Object.entries(view.groups).map(([group, names]) => (
        <details key={group} open={Object.keys(view.groups).length < 3 || names.length < 8}>
          <summary>
            {group} <span className="hint">{names.length} {names.length === 1 ? "joint" : "joints"}</span>
          </summary>
          <p className="states">
            {Object.entries(view.states[group] ?? {}).map(([name, at]) => (
              <button key={name} title={`Where ${group} is ${name}`} onClick={() => set(new Map([...joints, ...Object.entries(at)]))}>
                <Stands space={space} at={at} />
                {name}
              </button>
            ))}
          </p>
          <Keep group={group} names={names} view={view} joints={joints} />
          {names.map((name) => {
            const joint = known.get(name);
            if (!joint) return null;
            const [low, high] = joint.limits.length === 2 && joint.limits[0] !== joint.limits[1] ? (joint.limits as [number, number]) : [-Math.PI, Math.PI];
            const at = joints.get(name) ?? view.rest[name] ?? 0;
            const words = `${at.toFixed(3)} ${joint.type === "prismatic" ? "m" : "rad"}`;
            return (
              <label key={name} className="joint">
                <span>{name}</span>
                <input type="range" aria-label={name} min={low} max={high} step={(high - low) / 200} value={at} aria-valuetext={words} onChange={(event) => set(new Map(joints).set(name, Number(event.target.value)))} />
                {/* The slider says it; dozens change at once where the hand is moved. */}
                <output aria-live="off" aria-hidden="true">
                  {words}
                </output>
                <span className="hint">
                  {low.toFixed(2)} to {high.toFixed(2)}
                </span>
              </label>
            );
          })}
        </details>
      ))}
      <p>
        <button onClick={() => void taskThrough()}>New task through the kept positions</button>
      </p>
      <h3>What its files said</h3>
      {view.findings.length === 0 ? (
        <p className="phase-success">✓ Nothing had to be mended or left out.</p>
      ) : (
        <ul aria-label="What its files said">
          {view.findings.map((finding) => (
            <li key={finding}>{finding}</li>
          ))}
        </ul>
      )}
    </div>
  );
}

/** How the robot stands in a named state, all else at rest. */
function Stands({ space, at }: { space: Space | null; at: Readonly<Record<string, number>> }): JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null);
  const dark = useDark();
  useEffect(() => {
    const asked = requestAnimationFrame(() => canvas.current && space?.picture(new Map(Object.entries(at)), canvas.current));
    return () => cancelAnimationFrame(asked);
  }, [space, at, dark]);
  return <canvas ref={canvas} width={176} height={132} aria-hidden="true" />;
}

/** Keep where a group is now, under a name that tasks can go to. */
function Keep({ group, names, view, joints }: { group: string; names: readonly string[]; view: GeometryView; joints: ReadonlyMap<string, number> }): JSX.Element {
  const [name, setName] = useState("");
  const [said, setSaid] = useState("");
  async function keep(): Promise<void> {
    const at = Object.fromEntries(names.map((joint) => [joint, Number((joints.get(joint) ?? view.rest[joint] ?? 0).toFixed(4))]));
    setSaid(await keepState(group, name.trim(), at));
    setName("");
  }
  return (
    <form
      className="keep"
      onSubmit={(event) => {
        event.preventDefault();
        void keep();
      }}
    >
      <input type="text" aria-label={`Name for where ${group} is now`} placeholder="name of this position" value={name} onChange={(event) => setName(event.target.value)} />
      <button disabled={name.trim() === ""}>Keep</button>
      <output className="hint">{said}</output>
    </form>
  );
}

const said = (numbers: readonly number[]): string => numbers.map((each) => String(Number(each.toFixed(3)))).join(", ");
const read = (text: string): number[] | null => {
  const numbers = text.split(/[\s,;]+/).filter(Boolean).map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) ? numbers : null;
};

/** Where a hand is, by numbers: the arm follows as far as it reaches. */
function Reach({ view, hand, joints, set }: { view: GeometryView; hand: string; joints: ReadonlyMap<string, number>; set: JointsProps["set"] }): JSX.Element {
  const arm = useMemo(() => {
    const frame = view.grasp[hand];
    return frame === undefined ? null : makeReach(view, frame);
  }, [view, hand]);
  const now = useMemo(() => arm?.where(joints), [arm, joints]);
  const [fault, setFault] = useState("");
  /** Returns whether it could be read. */
  function go(part: "position" | "turn", text: string): boolean {
    if (arm === null || now === undefined || text === said(now[part])) return true;
    const numbers = read(text);
    if (numbers === null) setFault("Three numbers, such as 0.4, 0, 0.3.");
    if (numbers === null) return false;
    const found = arm.reach({ ...now, [part]: numbers }, joints);
    set(found.joints);
    setFault(isNear(found) ? "" : `It doesn't get there: ${found.off[0].toFixed(3)} m and ${found.off[1].toFixed(2)} rad are left.`);
    return true;
  }
  if (now === undefined) return <></>;
  return (
    <fieldset className="reach">
      <legend>{hand} at</legend>
      {(["position", "turn"] as const).map((part) => (
        <label key={part}>
          <span>{part === "position" ? "x, y, z [m]" : "roll, pitch, yaw [rad]"}</span>
          <Numbers label={part === "position" ? `Position of ${hand}` : `Orientation of ${hand}`} now={said(now[part])} go={(text) => go(part, text)} />
        </label>
      ))}
      {fault && <p className="doubt" role="alert">{fault}</p>}
    </fieldset>
  );
}

/** Where something is, until somebody types; Enter, or going elsewhere, moves it there. */
function Numbers({ label, now, go }: { label: string; now: string; go: (text: string) => boolean }): JSX.Element {
  const [typed, setTyped] = useState<string | null>(null);
  function commit(): void {
    if (typed !== null && go(typed)) setTyped(null);
  }
  return <input type="text" aria-label={label} value={typed ?? now} onChange={(event) => setTyped(event.target.value)} onBlur={commit} onKeyDown={(event) => event.key === "Enter" && commit()} />;
}
