/** Whether a container can be edited in both forms; where it can't, which edges are in the way. */
import type { JSX } from "react";

import type { FormsView, FormView } from "../../protocol/generated";
import { useDocument } from "../../store/document";
import { usePage } from "../../store/page";

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
      <span className="form-badge" title="Tree and flow chart edit it alike">
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
