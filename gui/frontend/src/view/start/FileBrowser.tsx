/** Folders and files of the machine that the server runs on, to be chosen from instead of typed. */
import { type JSX, type KeyboardEvent, useEffect, useRef, useState } from "react";

import { server } from "../../protocol/client";
import type { FolderView } from "../../protocol/generated";

type EntryKind = FolderView["kind"];

/** Something in a folder. */
export interface Entry {
  readonly name: string;
  readonly kind: EntryKind;
}

interface BrowserProps {
  /** What can be chosen: of a file, its name decides; of a folder, what it is. */
  readonly fits: (entry: Entry) => boolean;
  readonly chosen: string;
  readonly choose: (path: string) => void;
}

const MARKS: Record<EntryKind, string> = { moveit: "MoveIt configuration", package: "ROS package", folder: "", file: "" };
const SHAPES: Record<"folder" | "file", string> = { folder: "M2 4h4l1.5 2H14v7H2z", file: "M4 2h5l3 3v9H4zM9 2v3h3" };

export default function FileBrowser({ fits, chosen, choose }: BrowserProps): JSX.Element {
  const [view, setView] = useState<FolderView | null>(null);
  const [error, setError] = useState("");
  /** The beginning of a name, letter by letter. */
  const typed = useRef("");
  function go(at: string): void {
    typed.current = "";
    server.browse(at).then(
      (found) => {
        // A project that begins is empty: what is looked for lies beside it.
        if (at === "" && found.above !== "" && Object.keys(found.entries).length === 0) return go(found.above);
        setView(found);
        setError("");
      },
      (why: unknown) => setError(why instanceof Error ? why.message : String(why)),
    );
  }
  useEffect(() => go(""), []);
  // Who opens a folder by a key has the focus on what isn't there any more: it goes on in that folder.
  const list = useRef<HTMLUListElement>(null);
  const before = useRef<FolderView | null>(null);
  useEffect(() => {
    const asked = before.current === null && view !== null && list.current?.closest("dialog");
    if (asked || (before.current !== null && document.activeElement === document.body)) list.current?.focus();
    before.current = view;
  }, [view]);
  /** Letters find a name by its beginning, as in other lists of files; they are no keys of the page. */
  function onKeyDown(event: KeyboardEvent): void {
    if (event.key.length !== 1 || event.key === " " || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const rows = [...(list.current?.querySelectorAll<HTMLButtonElement>("li > .setup-file") ?? [])];
    const found = (text: string): HTMLButtonElement | undefined => rows.find((row) => row.textContent.trim().toLowerCase().startsWith(text));
    const letter = event.key.toLowerCase();
    typed.current = found(typed.current + letter) ? typed.current + letter : letter;
    found(typed.current)?.focus();
  }
  if (view === null) return <p className="hint" role="status">{error || "Looking ..."}</p>;
  const join = (name: string): string => `${view.at === "/" ? "" : view.at}/${name}`;
  const steps = view.at.split("/").filter(Boolean);
  const here: Entry = { name: steps.at(-1) ?? "/", kind: view.kind };
  return (
    <div className="browser" onKeyDown={onKeyDown}>
      <nav aria-label="Folder">
        <button className="link" onClick={() => go("/")}>/</button>
        {steps.map((step, at) => (
          <button key={at} className="link" aria-current={at === steps.length - 1 ? "location" : undefined} onClick={() => go(`/${steps.slice(0, at + 1).join("/")}`)}>
            {step}
          </button>
        ))}
      </nav>
      {error && <p className="fault" role="alert">{error}</p>}
      {fits(here) && (
        <p>
          <button aria-pressed={chosen === view.at} onClick={() => choose(view.at)}>
            Choose this folder
          </button>{" "}
          <span className="hint">{MARKS[view.kind]}</span>
        </p>
      )}
      <ul ref={list} className="plain scroll" tabIndex={0} aria-label={`What lies in ${here.name}`}>
        {view.above !== "" && (
          <li>
            <Row entry={{ name: "..", kind: "folder" }} pressed={false} press={() => go(view.above)} />
          </li>
        )}
        {Object.entries(view.entries)
          .map(([name, kind]) => ({ name, kind }))
          .filter((entry) => entry.kind !== "file" || fits(entry))
          .map((entry) => (
            <li key={entry.name}>
              <Row entry={entry} pressed={chosen === join(entry.name)} press={() => (entry.kind === "file" ? choose(join(entry.name)) : go(join(entry.name)))} />
              {entry.kind !== "file" && fits(entry) && (
                <button className="browser-take" aria-label={`Choose the folder ${entry.name}`} aria-pressed={chosen === join(entry.name)} onClick={() => choose(join(entry.name))}>
                  Choose
                </button>
              )}
            </li>
          ))}
      </ul>
    </div>
  );
}

function Row({ entry, pressed, press }: { entry: Entry; pressed: boolean; press: () => void }): JSX.Element {
  return (
    <button className="setup-file" aria-pressed={entry.kind === "file" ? pressed : undefined} onClick={press}>
      <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
        <path d={SHAPES[entry.kind === "file" ? "file" : "folder"]} />
      </svg>{" "}
      {entry.name === ".." ? ".. (one folder up)" : entry.name} {MARKS[entry.kind] && <span className="browser-mark">{MARKS[entry.kind]}</span>}
    </button>
  );
}
