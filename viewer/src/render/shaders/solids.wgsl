// Things that stand in the world, one instance each; shadows of characters fall on those that lie on the ground.

@group(1) @binding(0) var mask: texture_2d<f32>;
@group(1) @binding(1) var mask_sampler: sampler;

struct SolidIn {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) placement: vec4<f32>,
    @location(3) colour: vec4<f32>,
}

struct SolidOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) world: vec3<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
}

// Panels whose upper side is the ground are in front of it.
const BEFORE_GROUND: f32 = 1.0006;

@vertex
fn solid_vertex(in: SolidIn) -> SolidOut {
    let s = sin(in.placement.w);
    let c = cos(in.placement.w);
    let turn = mat3x3(vec3(c, 0.0, -s), vec3(0.0, 1.0, 0.0), vec3(s, 0.0, c));
    let world = turn * in.position + in.placement.xyz;
    let clip = scene.view_proj * vec4(world, 1.0);
    var out: SolidOut;
    out.clip = vec4(clip.xy, clip.z * BEFORE_GROUND, clip.w);
    out.normal = turn * in.normal;
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
