// The third-party part of the viewer's page: three.js, and what its examples add for controls and for meshes.
export * from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";
