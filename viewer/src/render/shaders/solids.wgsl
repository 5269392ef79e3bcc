// Things that stand in the world, one instance each; shadows of characters fall on those that lie on the ground.

@group(1) @binding(0) var mask: texture_2d<f32>;
@group(1) @binding(1) var mask_sampler: sampler;

struct SolidIn {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) at: vec3<f32>,
    @location(3) colour: vec4<f32>,
    @location(4) turn: vec4<f32>,
}

struct SolidOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) world: vec3<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
}

// Panels whose upper side is the ground are in front of it.
const BEFORE_GROUND: f32 = 1.0006;

// Turns a vector by a unit quaternion.
fn turned(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

@vertex
fn solid_vertex(in: SolidIn) -> SolidOut {
    let world = turned(in.turn, in.position) + in.at;
    let clip = scene.view_proj * vec4(world, 1.0);
    var out: SolidOut;
    out.clip = vec4(clip.xy, clip.z * BEFORE_GROUND, clip.w);
    out.normal = turned(in.turn, in.normal);
    out.world = world;
    out.colour = vec4(to_linear(in.colour.rgb), in.colour.a);
    return out;
}

@fragment
fn solid_fragment(in: SolidOut) -> @location(0) vec4<f32> {
    var colour = lit(in.colour.rgb, in.normal, in.world);
    let shadow = textureSampleLevel(mask, mask_sampler, in.clip.xy / scene.viewport.xy, 0.0).rg;
    let on_ground = (1.0 - smoothstep(0.005, 0.02, abs(in.world.y))) * step(0.9, in.normal.y);
    let dark = scene.shadow.a * on_ground * max(shadow.r * 0.85, shadow.g);
    colour = mix(colour, scene.shadow.rgb, dark);
    let away = in.world.xz - scene.eye.xz;
    let far = smoothstep(0.25, 1.0, length(away) / scene.eye.w);
    return vec4(mix(colour, scene.horizon.rgb, far), in.colour.a);
}
