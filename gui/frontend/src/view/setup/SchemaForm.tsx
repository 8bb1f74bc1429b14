/** A form made from the shape of a file: each field is one value of the text, and changes nothing but that. */
import { type JSX, useId, useState } from "react";
import { entryShape, formKind, freeName, type Key, listOf, optionsAt, pathAt, pathFrom, resolved, type Shape, shapeAt, valueAt } from "../../model/shapes";
import { topicsAt } from "../../model/parts";
import type { SetupView } from "../../protocol/generated";
import { askFile } from "../../store/ask";
import { useLive } from "../../store/live";
import { Prose } from "../edit/fields";
import { removeValue, renameValue, setValue } from "../../store/setup";
import { useProject } from "../../store/tasks";

interface FieldProps {
  readonly view: SetupView;
  readonly place: Key;
  readonly shape: Shape;
  /** Whether the name stands above already. */
  readonly bare?: boolean;
}

export function SchemaForm({ view }: { view: SetupView }): JSX.Element {
  if (view.data === null || typeof view.data !== "object") return <p className="hint">The text is not valid YAML; fix it on the right.</p>;
  return <Value view={view} place={[]} shape={view.shape as Shape} />;
}

/** How an arm plans, in the order in which one thinks of it. */
const MOTION = ["planner", "kinematics", "planning_time", "attempts", "speed", "acceleration", "jerk"];

/** Planner and kinematics of each arm, and their numbers; all else of an arm is in the whole file's form. */
export function MotionForm({ view }: { view: SetupView }): JSX.Element {
  const arms = valueAt(view.data, ["arms"]);
  const names = typeof arms === "object" && arms !== null ? Object.keys(arms) : [];
  const shape = resolved(shapeAt(view.shape as Shape, ["arms", "?"]), view.shape as Shape, {});
  if (names.length === 0) return <p className="hint">The project has no arm yet: choose a robot, or name an arm in grip.yaml.</p>;
  return (
    <div className="setup-cards">
      {names.map((name) => (
        <fieldset key={name} aria-label={`Motion of ${name}`}>
          <legend>
            {name} <span className="hint">group {String(valueAt(view.data, ["arms", name, "group"]) ?? "arm")}</span>
          </legend>
          {MOTION.filter((key) => shape.properties?.[key]).map((key) => (
            <Value key={key} view={view} place={["arms", name, key]} shape={shape.properties?.[key] ?? {}} />
          ))}
        </fieldset>
      ))}
    </div>
  );
}

export function Value({ view, place, shape, bare = false }: FieldProps): JSX.Element {
  const value = valueAt(view.data, place);
  const exact = resolved(shape, view.shape as Shape, value);
  switch (formKind(exact)) {
    case "fields":
      // A short form that the file's reader understands, such as a port's type alone.
      if (typeof value === "string") return <Scalar view={view} place={place} shape={{ type: "string" }} />;
      return <Fields view={view} place={place} shape={exact} bare={bare} />;
    case "entries":
      return <Entries view={view} place={place} shape={exact} bare={bare} />;
    case "items":
      return <Items view={view} place={place} shape={exact} />;
    default:
      return <Scalar view={view} place={place} shape={exact} />;
  }
}

function labelOf(place: Key): string {
  return String(place.at(-1) ?? "").replaceAll("_", " ");
}

function problemsAt(view: SetupView, place: Key): SetupView["problems"] {
  return place.length === 0 ? [] : view.problems.filter(({ key }) => place.every((step, at) => String(step) === key[at]));
}

/** What is said of a value, without its place, which is where it is said. */
function reasonAt(problems: SetupView["problems"]): string {
  return problems
    .map(({ key, message }) => {
      const place = [key.join("/"), key.at(-1) ?? ""].find((words) => message.startsWith(`${words}: `));
      return place === undefined ? message : message.slice(place.length + 2);
    })
    .join("; ");
}

function Fields({ view, place, shape, bare = false }: FieldProps): JSX.Element {
  const value = valueAt(view.data, place);
  const keys = Object.keys(shape.properties ?? {}).filter((key) => key !== "grip");
  const said = typeof value === "object" && value !== null ? keys.filter((key) => key in value) : [];
  const present = said.length > 0;
  // What is set stands first, as it was when the part was opened: nothing moves below the fingers.
  const [first, setFirst] = useState<readonly string[]>(said);
  if (present !== first.length > 0) setFirst(said);
  if (place.length > 0) keys.sort((a, b) => Number(first.includes(b)) - Number(first.includes(a)));
  const drawn = (key: string): JSX.Element => <Value key={key} view={view} place={[...place, key]} shape={shape.properties?.[key] ?? {}} />;
  // Of a part, whole parts that nothing is said of are folded away: a robot has a dozen of them.
  const isPart = (key: string): boolean => !first.includes(key) && ["fields", "entries", "items"].includes(formKind(resolved(shape.properties?.[key] ?? {}, view.shape as Shape, undefined)));
  const more = place.length > 0 ? keys.filter(isPart) : [];
  const all = (
    <>
      {keys.filter((key) => !more.includes(key)).map(drawn)}
      {more.length > 1 ? (
        <details className="setup-more">
          <summary>
            More <span className="hint">{more.map((key) => key.replaceAll("_", " ")).join(", ")}</span>
          </summary>
          {more.map(drawn)}
        </details>
      ) : (
        more.map(drawn)
      )}
    </>
  );
  if (place.length === 0) return <>{all}</>;
  if (value === undefined || value === null)
    return (
      <p className="setup-absent">
        <button onClick={() => void setValue([...place], {})}>Add {labelOf(place)}</button> <span className="hint">
          <Prose text={shape.description?.split("\n")[0] ?? ""} />
        </span>
      </p>
    );
  if (bare) return <>{all}</>;
  const optional = typeof place.at(-1) === "string" && place.length > 0;
  return (
    <fieldset>
      <legend>{labelOf(place)}</legend>
      {all}
      {optional && place.length === 1 && <button onClick={() => void removeValue([...place])}>Remove {labelOf(place)}</button>}
    </fieldset>
  );
}

/** A mapping whose keys are names that people give. */
function Entries({ view, place, shape, bare = false }: FieldProps): JSX.Element {
  const value = (valueAt(view.data, place) ?? {}) as Record<string, unknown>;
  const names = typeof value === "object" ? Object.keys(value) : [];
  const inner = entryShape(shape);
  const simple = !["fields", "entries", "items"].includes(formKind(resolved(inner, view.shape as Shape, undefined)));
  const [name, setName] = useState("");
  const what = labelOf(place) || "entries";
  const known = (optionsAt(view.options, [...place, "?"]) ?? []).filter((option) => !names.includes(option));
  const list = useId();
  function add(): void {
    const kind = formKind(resolved(inner, view.shape as Shape, undefined));
    const start = kind === "number" ? 0 : kind === "list" || kind === "items" ? [] : kind === "text" || kind === "choice" ? "" : {};
    void setValue((now) => [...place, freeName(name.trim() || "new", Object.keys(valueAt(now.data, place) ?? {}))], start);
    setName("");
  }
  return (
    <fieldset className={simple ? "setup-simple" : ""}>
      <legend className={bare || place.length === 0 ? "hidden" : ""}>{what}</legend>
      {names.map((entry) => (
        <div key={entry} className="setup-entry" role="group" aria-label={`${what} ${entry}`}>
          <div className="setup-name">
            <Named place={[...place, entry]} what={what} />
            <button aria-label={`Remove ${entry} from ${what}`} onClick={() => void removeValue([...place, entry])}>
              Remove
            </button>
          </div>
          <Value view={view} place={[...place, entry]} shape={inner} bare />
        </div>
      ))}
      <div className="setup-add">
        <input type="text" aria-label={`Name of a new one in ${what}`} placeholder="name" list={known.length > 0 ? list : undefined} value={name} onChange={(event) => setName(event.target.value)} onKeyDown={(event) => event.key === "Enter" && add()} />
        {known.length > 0 && (
          <datalist id={list}>
            {known.map((option) => (
              <option key={option} value={option} />
            ))}
          </datalist>
        )}
        <button onClick={add} aria-label={`Add to ${what}`}>
          Add
        </button>
      </div>
    </fieldset>
  );
}

function Named({ place, what }: { place: Key; what: string }): JSX.Element {
  const name = String(place.at(-1));
  return (
    <input
      type="text"
      key={name}
      defaultValue={name}
      aria-label={`Name of ${name} in ${what}`}
      onBlur={(event) => {
        const next = event.target.value.trim();
        if (next && next !== name) void renameValue([...place], next);
        else event.target.value = name;
      }}
      onKeyDown={(event) => event.key === "Enter" && event.currentTarget.blur()}
    />
  );
}

function Items({ view, place, shape }: FieldProps): JSX.Element {
  const value = valueAt(view.data, place);
  const count = Array.isArray(value) ? value.length : 0;
  return (
    <fieldset>
      <legend>{labelOf(place)}</legend>
      {Array.from({ length: count }, (_, at) => (
        <div key={at} className="setup-entry" role="group" aria-label={`${labelOf(place)} ${at + 1}`}>
          <div className="setup-name">
            <strong>{at + 1}</strong>
            <button onClick={() => void removeValue([...place, at])}>Remove number {at + 1}</button>
          </div>
          <Value view={view} place={[...place, at]} shape={shape.items ?? {}} bare />
        </div>
      ))}
      <button onClick={() => void setValue([...place, count], {})}>Add to {labelOf(place)}</button>
    </fieldset>
  );
}

function Scalar({ view, place, shape }: FieldProps): JSX.Element {
  const id = useId();
  const value = valueAt(view.data, place);
  const topics = useLive((s) => s.topics);
  const options = topicsAt(topics?.topics, place) ?? optionsAt(view.options, place) ?? (shape.enum ? shape.enum.map(String) : undefined);
  const problems = problemsAt(view, place);
  const reason = reasonAt(problems);
  const wrong = problems.some((problem) => problem.severity === "error");
  const kind = formKind(shape);
  const shown = Array.isArray(value) ? value.join(", ") : value === undefined || value === null ? "" : typeof value === "object" ? JSON.stringify(value) : String(value);
  const hint = shape.default === undefined || shape.default === null || shape.default === "" ? "" : `${Array.isArray(shape.default) ? shape.default.join(", ") : String(shape.default)}`;
  function take(text: string): void {
    if (text === shown) return;
    if (text.trim() === "") void removeValue([...place]);
    else if (kind === "number") void setValue([...place], Number.isNaN(Number(text)) ? text : Number(text));
    else if (kind === "list") void setValue([...place], listOf(text, shape.items?.type === "number"));
    else void setValue([...place], text);
  }
  const common = { id, "aria-invalid": wrong, ...(reason || shape.description ? { "aria-describedby": `${id}-said` } : {}) };
  return (
    <div className="form-field">
      <label htmlFor={id}>{labelOf(place)}</label>
      {kind === "flag" ? (
        <input {...common} type="checkbox" checked={value === undefined ? shape.default === true : value === true} onChange={(event) => void setValue([...place], event.target.checked)} />
      ) : options && options.length > 0 ? (
        <>
          <input {...common} type="text" list={`${id}-list`} key={shown} defaultValue={shown} placeholder={hint} onBlur={(event) => take(event.target.value)} onKeyDown={(event) => event.key === "Enter" && take(event.currentTarget.value)} onInput={(event) => options.includes(event.currentTarget.value) && take(event.currentTarget.value)} />
          <datalist id={`${id}-list`}>
            {options.map((option) => (
              <option key={option} value={option} />
            ))}
          </datalist>
        </>
      ) : (
        <input {...common} type="text" inputMode={kind === "number" ? "decimal" : "text"} key={shown} defaultValue={shown} placeholder={hint} onBlur={(event) => take(event.target.value)} onKeyDown={(event) => event.key === "Enter" && take(event.currentTarget.value)} />
      )}
      {pathAt(place) !== undefined && (
        <button aria-label={`Browse for ${labelOf(place)}`} onClick={() => void browse(view, place)}>
          Browse ...
        </button>
      )}
      {(reason || shape.description) && (
        <p id={`${id}-said`} className={wrong ? "fault" : reason ? "doubt" : "hint"}>
          {reason || <Prose text={shape.description ?? ""} />}
        </p>
      )}
    </div>
  );
}

/** Choose the file or the folder that stands at a place; it is written as a path from where the file with the form lies. */
async function browse(view: SetupView, place: Key): Promise<void> {
  const ends = pathAt(place);
  const found = await askFile({
    title: `Browse for ${labelOf(place)}`,
    fits: ({ name, kind }) => (ends ? kind === "file" && ends.test(name) : place.at(-1) === "moveit" ? kind === "moveit" : kind !== "file"),
  });
  const home = `${useProject.getState().project?.folder ?? ""}/${view.path}`.split("/").slice(0, -1).join("/");
  if (found !== null) await setValue([...place], pathFrom(home, found));
}
