// A mesh of the user's own: its colours and textures, light, and an edge in the colour of the character.

struct Shaded {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) world: vec3<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
    @location(3) @interpolate(flat) is_selected: u32,
    @location(4) place: vec2<f32>,
    @location(5) @interpolate(flat) layer: u32,
    // Colour of the character, and its alpha.
    @location(6) @interpolate(flat) told: vec4<f32>,
}

@group(2) @binding(0) var textures: texture_2d_array<f32>;
@group(2) @binding(1) var smooth_sampler: sampler;

@vertex
fn vertex(v: BodyVertex) -> Shaded {
    let skinned = skin(v);
    let instance = instances[v.character];
    let told = unpack4x8unorm(instance.colour);
    var out: Shaded;
    out.clip = scene.view_proj * vec4(skinned.position, 1.0);
    out.normal = skinned.normal;
    out.world = skinned.position;
    out.colour = vec4(to_linear(v.colour.rgb), v.colour.a);
    out.is_selected = instance.is_selected;
    out.place = v.place;
    out.layer = v.layer;
    out.told = vec4(to_linear(told.rgb), told.a);
    return out;
}

@fragment
fn fragment(in: Shaded, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    let texel = textureSample(textures, smooth_sampler, in.place, in.layer);
    if texel.a < in.colour.a {
        discard;
    }
    let normal = select(-in.normal, in.normal, is_front);
    let facing = abs(dot(normalize(normal), normalize(scene.eye.xyz - in.world)));
    let albedo = mix(in.colour.rgb * texel.rgb, in.told.rgb, 0.6 * smoothstep(0.45, 0.9, 1.0 - facing));
    return vec4(edged(lit(albedo, normal, in.world), facing, in.is_selected), in.told.a);
}
