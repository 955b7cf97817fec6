// What the graphics card computes of the 3-D view: moved and cut points, shaded faces, round marks.
"use strict";
const FACES = `#version 300 es
layout(location=0) in vec3 point; layout(location=1) in vec3 before; layout(location=2) in vec3 after;
uniform mat3 turn; uniform vec4 frame, cut; uniform vec2 size; uniform vec3 motion; uniform float nearer, dotsize;
out vec3 seen; out float beyond, moved;
void main() {
  vec3 u = mix(before, after, motion.y), at = point * frame.w + u * motion.x, p = turn * (at - frame.xyz);
  seen = p; beyond = dot(cut.xyz, at) - cut.w; moved = length(u) / 32767.0;
  gl_Position = vec4(p.xy / size, -p.z * motion.z - nearer, 1.0);
  gl_PointSize = dotsize;
}`;
const SHADE = `#version 300 es
precision highp float;
in vec3 seen; in float beyond, moved; uniform vec4 colour; uniform float lit, tinted; out vec4 pixel;
void main() {
  if (beyond > 0.0) discard;
  float m = clamp(moved, 0.0, 1.0);
  vec3 tint = m < 0.5 ? mix(vec3(0.27, 0.22, 0.55), vec3(0.13, 0.6, 0.55), 2.0 * m)
                      : mix(vec3(0.13, 0.6, 0.55), vec3(0.99, 0.89, 0.15), 2.0 * m - 1.0);
  vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
  float bright = 0.56 + 0.5 * clamp(abs(dot(n, normalize(vec3(-0.35, 0.45, 0.82)))), 0.0, 1.0);
  pixel = vec4(mix(colour.rgb, tint, tinted) * mix(1.0, bright, lit), colour.a);
}`;
const DOTS = `#version 300 es
layout(location=0) in vec3 point; layout(location=1) in vec3 before; layout(location=2) in vec3 after;
layout(location=3) in float hot0; layout(location=4) in float hot1;
uniform mat3 turn; uniform vec4 frame, cut; uniform vec2 size; uniform vec3 motion; uniform float nearer, dotsize;
out float hot, beyond;
void main() {
  vec3 at = point * frame.w + mix(before, after, motion.y) * motion.x, p = turn * (at - frame.xyz);
  beyond = dot(cut.xyz, at) - cut.w;
  hot = mix(hot0, hot1, motion.y);
  gl_Position = vec4(p.xy / size, -p.z * motion.z - nearer, 1.0);
  gl_PointSize = dotsize * (1.0 + 1.6 * hot);
}`;
const ROUND = `#version 300 es
precision highp float;
in float hot, beyond; uniform vec4 colour; uniform vec4 rim; out vec4 pixel;
void main() {
  if (beyond > 0.0) discard;
  float r = length(gl_PointCoord - 0.5) * 2.0;
  if (r > 1.0) discard;
  vec3 warm = mix(vec3(0.97, 0.79, 0.28), vec3(0.80, 0.06, 0.16), hot);
  vec3 inside = hot > 0.0 ? warm : colour.rgb;
  pixel = vec4(mix(inside, rim.rgb, smoothstep(0.66, 0.78, r)), colour.a);
}`;
