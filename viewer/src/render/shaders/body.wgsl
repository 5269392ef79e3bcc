// Bodies: colour by part and side, light, and an edge where emphasised.

struct Shaded {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) world: vec3<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
    @location(3) @interpolate(flat) emphasis: u32,
}

// Colour of a part (sRGB), and how much of it is its own rather than the character's.
fn part_colour(part: u32) -> vec4<f32> {
    switch part {
        case 0u: { return vec4(0.88, 0.76, 0.66, 0.86); }
        case 2u: { return vec4(0.23, 0.26, 0.32, 0.62); }
        case 3u: { return vec4(0.13, 0.14, 0.17, 0.86); }
        case 4u: { return vec4(0.93, 0.91, 0.86, 0.92); }
        case 5u: { return vec4(0.10, 0.12, 0.15, 0.94); }
        default: { return vec4(0.5, 0.5, 0.5, 0.0); }
    }
}

// The left side is lighter, the right side darker.
fn sided(colour: vec3<f32>, side: u32, part: u32) -> vec3<f32> {
    let strength = select(1.0, 0.35, part == 0u);
    if side == 1u {
        return mix(colour, vec3(1.0), 0.20 * strength);
    }
    if side == 2u {
        return mix(colour, vec3(0.0), 0.20 * strength);
    }
    return colour;
}

@vertex
fn vertex(v: BodyVertex) -> Shaded {
    let skinned = skin(v);
    let instance = instances[v.character];
    let base = unpack4x8unorm(instance.colour);
    let part = v.part & 7u;
    let own = part_colour(part);
    let colour = sided(mix(base.rgb, own.rgb, own.a), v.part >> 3u, part);
    var out: Shaded;
    out.clip = scene.view_proj * vec4(skinned.position, 1.0);
    out.normal = skinned.normal;
    out.world = skinned.position;
    out.colour = vec4(to_linear(colour), base.a);
    out.emphasis = instance.emphasis;
    return out;
}

@fragment
fn fragment(in: Shaded) -> @location(0) vec4<f32> {
    var colour = lit(in.colour.rgb, in.normal, in.world);
    if in.emphasis != 0u {
        let edge = select(scene.highlighted.rgb, scene.selected.rgb, in.emphasis == 2u);
        let facing = abs(dot(normalize(in.normal), normalize(scene.eye.xyz - in.world)));
        colour = mix(colour, edge, 0.12 + 0.88 * smoothstep(0.35, 0.85, 1.0 - facing));
    }
    return vec4(colour, in.colour.a);
}
