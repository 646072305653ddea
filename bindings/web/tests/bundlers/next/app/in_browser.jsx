"use client";
import { useEffect } from "react";
import { report } from "../check_face.js";

export function InBrowser({ vertices }) {
  useEffect(() => report("/face.fbk"), []);
  return <p id="server">{vertices}</p>;
}
