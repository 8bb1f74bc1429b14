/** Above the canvas: where we are, which view, and undo, redo, save. */
import type { JSX } from "react";

import { nameOf } from "../../model/commands";
import type { FormsView, FormView } from "../../protocol/generated";
import { ACTIONS, actionTitle } from "../../store/actions";
import { goUp } from "../../store/converting";
import { chooseRun, openTask } from "../../store/desk";
import { useDocument } from "../../store/document";
import { redo, save, undo } from "../../store/editing";
import { usePage, type ViewName } from "../../store/page";
import { useRun } from "../../store/run";

const VIEWS: readonly [ViewName, string][] = [
  ["tree", "Tree"],
  ["flow", "Flow"],
  ["split", "Split"],
  ["text", "Text"],
  ["robot", "3D"],
];

export function EditBar(): JSX.Element {
  const document = useDocument((s) => s.document);
  const record = useRun((s) => s.record);
  const view = usePage((s) => s.view);
  const beside = usePage((s) => s.beside);
  const history = document?.history;
  const waiting = useDocument((s) => s.waiting);
  return (
    <div className="edit-bar" role="toolbar" aria-label="Editing">
      <div className="segments" role="group" aria-label="View">
        {VIEWS.map(([name, label]) => (
          <button key={name} aria-pressed={view === name} title={actionTitle(name)} onClick={() => usePage.getState().setView(name)}>
            {label}
          </button>
        ))}
      </div>
      {view === "split" && (
        <select aria-label="Beside the tree" value={beside} onChange={(event) => usePage.getState().setBeside(event.target.value as "flow" | "text")}>
          <option value="flow">with flow</option>
          <option value="text">with text</option>
        </select>
      )}
      <Trail />
      <span className="grow" />
      {record ? (
        <>
          <span className="hint">Record of a run: read only</span>
          <button onClick={() => void openTask(document?.path ?? record.task_path)}>Edit the task</button>
        </>
      ) : (
        <>
          <UnderWay />
          <button aria-label="Undo" title={actionTitle("undo")} disabled={!history?.can_undo} onClick={() => void undo()}>
            <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
              <path d="M6 3 2.500 6.500 6 10M2.500 6.500H10a3.500 3.500 0 0 1 0 7H6" />
            </svg>
          </button>
          <button aria-label="Redo" title={actionTitle("redo")} disabled={!history?.can_redo} onClick={() => void redo()}>
            <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
              <path d="M10 3l3.500 3.500L10 10M13.500 6.500H6a3.500 3.500 0 0 0 0 7h4" />
            </svg>
          </button>
          <button title={actionTitle("commands")} onClick={() => void ACTIONS[0]?.run()}>
            Commands
          </button>
          <button className={document?.saved ? "" : "main"} title={actionTitle("save")} disabled={!document || (document.saved && document.change === "")} onClick={() => void save()}>
            Save
          </button>
          <output className="saved-state" aria-label="State of the file">
            {document === null ? "" : waiting > 0 ? "waits for the server" : document.draft ? "text isn't a task" : document.saved ? "saved" : "not saved"}
          </output>
        </>
      )}
    </div>
  );
}

/** That a run of this task is under way while the task is edited, and the way back to it. */
function UnderWay(): JSX.Element | null {
  const session = useRun((s) => s.session);
  const path = useDocument((s) => s.document?.path);
  const run = session?.run;
  if (!run || session.state === "ended" || session.task !== path) return null;
  return (
    <>
      <span className="hint" title="What is changed here counts for the next run.">
        A run goes on with the text that it began with
      </span>
      <button onClick={() => void chooseRun(run)}>Show the run</button>
    </>
  );
}

export function Trail(): JSX.Element | null {
  const trail = usePage((s) => s.trail);
  const name = useRun((s) => s.task.name);
  if (trail.length === 0) return null;
  return (
    <nav aria-label="Tasks above">
      <ol className="crumbs">
        {trail.map((above, at) => (
          <li key={`${above.task} ${above.node}`}>
            <button className="link" title={`Back to ${above.task}, at ${above.node}`} onClick={() => void goUp(at)}>
              {above.name}/{nameOf(above.node)}
            </button>
          </li>
        ))}
        <li aria-current="page">{name}</li>
      </ol>
    </nav>
  );
}

/** Forms by path, found once for each answer of the server. */
const BY_PATH = new WeakMap<FormsView, ReadonlyMap<string, FormView>>();

function byPath(forms: FormsView): ReadonlyMap<string, FormView> {
  const known = BY_PATH.get(forms) ?? new Map(forms.forms.map((form) => [form.path, form]));
  BY_PATH.set(forms, known);
  return known;
}

export function useForm(path: string): FormView | undefined {
  return useDocument((s) => (s.forms === null ? undefined : byPath(s.forms).get(path)));
}

export function FormBadge({ path }: { path: string }): JSX.Element | null {
  const form = useForm(path);
  if (form === undefined) return null;
  if (form.both) {
    return (
      <span className="form-badge" title="Can be edited as a tree and as a flow chart">
        = both forms
      </span>
    );
  }
  return (
    <details className="form-why">
      <summary>~ one form only: why?</summary>
      <p>{form.reason}</p>
      {form.edges.map(([node, outcome]) => (
        <button key={`${node}.${outcome}`} className="link" onClick={() => usePage.getState().select(node)}>
          {node}.{outcome}
        </button>
      ))}
    </details>
  );
}
