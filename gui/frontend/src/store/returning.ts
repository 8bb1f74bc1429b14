/** What may have changed while the person was elsewhere: the file on disk, the project's nodes, its list of tasks. */
import { server } from "../protocol/client";
import { useDocument } from "./document";
import { take } from "./editing";
import { loadProject } from "./tasks";

/** Look again whenever the window gets the focus, until the returned function is called. */
export function lookAgainOnReturn(): () => void {
  const look = (): void => void lookAgain().catch(() => {});
  window.addEventListener("focus", look);
  return () => window.removeEventListener("focus", look);
}

async function lookAgain(): Promise<void> {
  const { document, catalog, setCatalog } = useDocument.getState();
  const found = await server.catalog();
  if (JSON.stringify(found) !== JSON.stringify(catalog)) setCatalog(found);
  await loadProject();
  if (document === null) return;
  const now = await server.document(document.path);
  if (useDocument.getState().document?.path === now.path) take(now);
}
