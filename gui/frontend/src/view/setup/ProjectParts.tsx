/** What a project has of what it needs to run, each that lacks with a button that adds it; and what a world's camera sees. */
import { type JSX, useEffect, useState } from "react";

import { partsOf } from "../../model/parts";
import { server } from "../../protocol/client";
import type { SetupView } from "../../protocol/generated";
import { begin, chooseRobot, useBegin } from "../../store/begin";
import { isDirty, saveSetup, useSetup } from "../../store/setup";
import { useProject } from "../../store/tasks";

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
                <button disabled={busy !== ""} aria-label={`Add ${part.title.toLowerCase()}`} onClick={() => void begin("")}>
                  Add
                </button>
              )
            )}
          </li>
        ))}
      </ul>
      {busy && <p className="hint" role="status">{busy}</p>}
      {error && <p className="fault" role="alert">{error}</p>}
      {made !== null && made.files.length === 0 && <p className="hint">The robot's files tell nothing more; what lacks is named in the form below.</p>}
    </div>
  );
}

/** What a camera of the world sees when everything has settled; drawn by the simulator, of the file as it is saved. */
export function WorldPicture({ view }: { view: SetupView }): JSX.Element {
  const name = view.path.replace(/^worlds\/|\.yaml$/g, "");
  const cameras = Object.keys((view.data as { cameras?: object } | null)?.cameras ?? {});
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
