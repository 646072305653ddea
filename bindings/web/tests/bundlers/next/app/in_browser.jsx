"use client";
import { useEffect } from "react";
import { report } from "../check_face.js";

export function InBrowser() {
  useEffect(() => report("/face.fbk"), []);
  return null;
}
