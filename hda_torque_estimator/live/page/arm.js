// The arm in three dimensions: a piece for each joint, an arrow for the push, a ring for each torque.
import * as THREE from 'three';
import {OrbitControls} from './vendor/OrbitControls.js';

const NEWTONS_A_METRE = 100;        // length of the arrow of a push: a choice
const PUSH = 0xd95f02, TORQUE = 0x1b9e77, LINK = 0x7d8aa0, JOINT = 0x5b6579;
const UP = new THREE.Vector3(0, 0, 1), ALONG = new THREE.Vector3(0, 1, 0);

export class Arm {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 100);
    this.camera.up.copy(UP);
    this.controls = new OrbitControls(this.camera, canvas);
    const sky = new THREE.HemisphereLight(0xffffff, 0x888899, 1.5), lamp = new THREE.DirectionalLight(0xffffff, 2);
    sky.position.copy(UP);
    this.camera.add(lamp);              // beside who looks: nothing is dark from where one stands
    this.scene.add(sky, this.camera);
    this.pieces = [];
    this.rings = [];
    this.push = arrow();
    this.scene.add(this.push);
  }

  show(picture) {
    if (picture.pieces) {
      if (picture.pieces.length !== this.pieces.length) this.build(picture.pieces);
      picture.pieces.forEach(([from, to], at) => this.place(this.pieces[at], from, to));
      this.showTorques(picture);
      this.showPush(picture);
    }
    this.fit();
    this.controls.update();
    this.renderer.render(this.scene, this.camera);
  }

  build(pieces) {
    const sizes = pieces.map(([from, to]) => distance(from, to));
    const reach = Math.max(0.05, sizes.reduce((sum, size) => sum + size, 0));
    const thick = reach / 40;
    this.pieces = pieces.map(() => piece(thick));
    this.rings = pieces.map(() => ring(thick * 2.6, thick / 3));
    this.pieces.forEach((each) => this.scene.add(each));
    this.rings.forEach((each) => this.scene.add(each));
    const grid = new THREE.GridHelper(reach * 3, 24, 0x8888aa, 0x8888aa);
    grid.material.transparent = true;
    grid.material.opacity = 0.25;
    grid.rotation.x = Math.PI / 2;
    this.scene.add(grid);
    this.look(pieces.flat(), reach);
  }

  look(points, reach) {
    const box = new THREE.Box3().setFromPoints(points.map((point) => new THREE.Vector3(...point)));
    const spatial = box.max.z - box.min.z > reach / 20;
    const [x, y, z] = spatial ? [0.7, -1.2, 0.5] : [0.2, -1.6, 1.9];     // from the side, or from above a plane
    if (spatial) box.getCenter(this.controls.target);
    else this.controls.target.set(reach * 0.2, reach * 0.1, 0);
    this.camera.position.set(x, y, z).multiplyScalar(reach).add(this.controls.target);
  }

  place(group, from, to) {
    const begin = new THREE.Vector3(...from), step = new THREE.Vector3(...to).sub(begin);
    const length = Math.max(step.length(), 1e-6);
    group.position.copy(begin);
    group.quaternion.setFromUnitVectors(ALONG, step.divideScalar(length));
    group.userData.link.scale.y = length;
    group.userData.link.position.y = length / 2;
  }

  showTorques(picture) {
    const largest = Math.max(5, ...(picture.estimate?.torque ?? []).map((value) => Math.abs(value ?? 0)));
    this.rings.forEach((each, at) => {
      const torque = picture.estimate?.torque[at];
      each.visible = torque != null && Math.abs(torque) > 1e-3;
      if (!each.visible) return;
      each.position.set(...picture.pieces[at][0]);
      const turn = Math.min(Math.abs(torque) / largest, 1) * 1.8 * Math.PI;
      each.geometry.dispose();
      each.geometry = new THREE.TorusGeometry(each.userData.radius, each.userData.thick, 8, 48, turn);
      each.scale.y = Math.sign(torque);
    });
  }

  showPush(picture) {
    const force = picture.tip_force?.map((value) => value ?? 0);
    const size = force ? Math.hypot(...force) : 0;
    this.push.visible = size > 0.5;
    if (!this.push.visible) return;
    const along = new THREE.Vector3(...force).divideScalar(size);
    this.push.position.set(...picture.pieces.at(-1)[1]);                // it ends at the tip
    this.push.quaternion.setFromUnitVectors(ALONG, along);
    const length = Math.max(size / NEWTONS_A_METRE, 0.04), {shaft, thick} = this.push.userData;
    shaft.scale.set(1, length, 1);
    shaft.position.y = -length / 2 - 3 * thick;
  }

  fit() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x === width && size.y === height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
  }
}

function piece(thick) {
  const group = new THREE.Group();
  const link = new THREE.Mesh(new THREE.CylinderGeometry(thick, thick, 1, 24),
    new THREE.MeshStandardMaterial({color: LINK, roughness: 0.6}));
  const joint = new THREE.Mesh(new THREE.CylinderGeometry(thick * 1.8, thick * 1.8, thick * 3, 32),
    new THREE.MeshStandardMaterial({color: JOINT, roughness: 0.5}));
  joint.rotation.x = Math.PI / 2;
  group.add(link, joint);
  group.userData.link = link;
  return group;
}

function arrow() {
  const group = new THREE.Group(), thick = 0.006;
  const material = new THREE.MeshBasicMaterial({color: PUSH});
  const head = new THREE.Mesh(new THREE.ConeGeometry(thick * 2.5, thick * 6, 24), material);
  head.position.y = -thick * 3;
  const shaft = new THREE.Mesh(new THREE.CylinderGeometry(thick, thick, 1, 16), material);
  group.add(shaft, head);
  group.userData = {shaft, thick};
  group.visible = false;
  return group;
}

function ring(radius, thick) {
  const made = new THREE.Mesh(new THREE.TorusGeometry(radius, thick, 8, 48, 1),
    new THREE.MeshBasicMaterial({color: TORQUE, side: THREE.DoubleSide}));
  made.userData = {radius, thick};
  made.visible = false;
  return made;
}

function distance(from, to) {
  return Math.hypot(...from.map((value, axis) => value - to[axis]));
}
