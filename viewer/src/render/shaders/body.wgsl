// Bodies: colour by part and side, light, and an edge where is_selecteded.

struct Shaded {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) world: vec3<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
    @location(3) @interpolate(flat) is_selected: u32,
}

// One of eight tones, dark to light (sRGB).
fn skin_tone(k: u32) -> vec3<f32> {
    let share = f32(k) / 7.0;
    return mix(mix(vec3(0.33, 0.21, 0.15), vec3(0.73, 0.53, 0.40), saturate(2.0 * share)), vec3(0.95, 0.82, 0.72), saturate(2.0 * share - 1.0));
}

// One of eight pairs of trousers.
fn trousers(k: u32) -> vec3<f32> {
    switch k {
        case 0u: { return vec3(0.17, 0.22, 0.34); }
        case 1u: { return vec3(0.55, 0.49, 0.38); }
        case 2u: { return vec3(0.13, 0.13, 0.15); }
        case 3u: { return vec3(0.35, 0.37, 0.40); }
        case 4u: { return vec3(0.33, 0.27, 0.20); }
        case 5u: { return vec3(0.28, 0.35, 0.28); }
        case 6u: { return vec3(0.25, 0.33, 0.47); }
        default: { return vec3(0.42, 0.24, 0.24); }
    }
}

// Colour of a part (sRGB), and how much of it is its own rather than the character's; by the bits of a look that is not 0.
fn part_colour(part: u32, look: u32) -> vec4<f32> {
    if look != 0u {
        switch part {
            case 0u: { return vec4(skin_tone(look & 7u), 0.94); }
            case 2u: { return vec4(trousers((look >> 3u) & 7u), 0.85); }
            case 3u: { return vec4(mix(vec3(0.12), vec3(0.5, 0.38, 0.28), f32((look >> 6u) & 3u) / 3.0), 0.9); }
            default: {}
        }
    }
    switch part {
        case 0u: { return vec4(0.88, 0.76, 0.66, 0.86); }
        case 2u: { return vec4(0.27, 0.30, 0.36, 0.62); }
        case 3u: { return vec4(0.17, 0.18, 0.21, 0.86); }
        case 4u: { return vec4(0.93, 0.91, 0.86, 0.92); }
        case 5u: { return vec4(0.10, 0.12, 0.15, 0.94); }
        default: { return vec4(0.5, 0.5, 0.5, 0.0); }
    }
}

// The left side is lighter, the right side darker.
fn sided(colour: vec3<f32>, side: u32, part: u32) -> vec3<f32> {
    let strength = select(1.0, 0.35, part == 0u);
    if side == 1u {
        return mix(colour, vec3(1.0), 0.13 * strength);
    }
    if side == 2u {
        return mix(colour, vec3(0.0), 0.13 * strength);
    }
    return colour;
}

@vertex
fn vertex(v: BodyVertex) -> Shaded {
    let skinned = skin(v);
    let instance = instances[v.character];
    let base = unpack4x8unorm(instance.colour);
    let part = v.part & 7u;
    let own = part_colour(part, instance.look);
    let colour = sided(mix(base.rgb, own.rgb, own.a), v.part >> 3u, part);
    var out: Shaded;
    out.clip = scene.view_proj * vec4(skinned.position, 1.0);
    out.normal = skinned.normal;
    out.world = skinned.position;
    out.colour = vec4(to_linear(colour), base.a);
    out.is_selected = instance.is_selected;
    return out;
}

@fragment
fn fragment(in: Shaded) -> @location(0) vec4<f32> {
    let facing = abs(dot(normalize(in.normal), normalize(scene.eye.xyz - in.world)));
    return vec4(edged(lit(in.colour.rgb, in.normal, in.world), facing, in.is_selected), in.colour.a);
}
