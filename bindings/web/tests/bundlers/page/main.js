import { report } from "./check_face.js";

report("/face.fbk");
