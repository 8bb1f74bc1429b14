import "@xyflow/react/dist/style.css";
import "./view/tokens.css";
import "./view/page.css";
import "./view/tree.css";
import "./view/edit.css";
import "./view/flow/flow.css";
import "./view/run.css";

import { StrictMode } from "react";
import { createRoot } from "react-dom/client";

import { Page } from "./view/Page";

createRoot(document.getElementById("page") as HTMLElement).render(
  <StrictMode>
    <Page />
  </StrictMode>,
);
