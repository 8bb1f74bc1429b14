/** Whether a container can be edited in both forms; where it can't, which edges are in the way. */
import type { JSX } from "react";

import { useDocument } from "../../store/document";
import { usePage } from "../../store/page";

export function useForm(path: string): { readonly both: boolean; readonly reason: string; readonly edges: readonly (readonly [string, string])[] } | undefined {
  return useDocument((s) => s.forms?.forms.find((form) => form.path === path));
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
