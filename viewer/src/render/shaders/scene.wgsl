// Shared by all shaders; `scene_uniform.rs` fills it.

struct Scene {
    view_proj: mat4x4<f32>,
    eye: vec4<f32>,
    right: vec4<f32>,
    up: vec4<f32>,
    forward: vec4<f32>,
    viewport: vec4<f32>,
    sun: vec4<f32>,
    sky: vec4<f32>,
    horizon: vec4<f32>,
    ground: vec4<f32>,
    grid: vec4<f32>,
    grid_strong: vec4<f32>,
    axis_x: vec4<f32>,
    axis_z: vec4<f32>,
    shadow: vec4<f32>,
    light_above: vec4<f32>,
    light_below: vec4<f32>,
    light_key: vec4<f32>,
    selected: vec4<f32>,
    rest: array<vec4<f32>, 22>,
}

@group(0) @binding(0) var<uniform> scene: Scene;

fn to_linear(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, c <= vec3(0.04045));
}

// Hemisphere light, sun with a soft terminator, a little light from the camera, and a faint sheen.
fn lit(albedo: vec3<f32>, normal: vec3<f32>, world: vec3<f32>) -> vec3<f32> {
    let n = normalize(normal);
    let v = normalize(scene.eye.xyz - world);
    let above = scene.light_above.rgb * scene.light_above.a;
    let below = scene.light_below.rgb * scene.light_below.a;
    let near_ground = 1.0 - 0.45 * (1.0 - smoothstep(0.0, 0.5, world.y)) * (0.5 - 0.5 * n.y);
    let hemisphere = mix(below, above, 0.5 + 0.5 * n.y) * near_ground;
    let cosine = dot(n, scene.sun.xyz);
    let key = scene.light_key.rgb * scene.light_key.a * pow(max(0.75 * cosine + 0.25, 0.0), 1.4);
    let fill = 0.10 * max(dot(n, v), 0.0);
    let sheen = scene.light_key.a * 0.06 * pow(max(dot(n, normalize(v + scene.sun.xyz)), 0.0), 22.0);
    return albedo * (hemisphere + key + fill) + sheen;
}

// Depth of what is drawn over everything else: the near half of the range, which the scene hardly uses.
fn layered(clip: vec4<f32>, on_top: u32) -> vec4<f32> {
    if on_top != 0u {
        return vec4(clip.xy, 0.5 * (clip.z + clip.w), clip.w);
    }
    return clip;
}
