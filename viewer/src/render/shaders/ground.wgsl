// The ground with its grid and shadows, and the sky behind it.

@group(1) @binding(0) var mask: texture_2d<f32>;
@group(1) @binding(1) var mask_sampler: sampler;

struct Surface {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec2<f32>,
}

fn corner(i: u32) -> vec2<f32> {
    return vec2(f32(i & 1u), f32((i >> 1u) & 1u)) * 2.0 - 1.0;
}

@vertex
fn ground_vertex(@builtin(vertex_index) i: u32) -> Surface {
    let place = corner(i) * scene.eye.w;
    var out: Surface;
    out.clip = scene.view_proj * vec4(scene.eye.x + place.x, 0.0, scene.eye.z + place.y, 1.0);
    out.place = place;
    return out;
}

// Coverage of lines `width` metres wide (at least about a pixel) every `spacing` metres; fades where they crowd.
fn lines(place: vec2<f32>, change: vec2<f32>, spacing: f32, width: f32) -> f32 {
    let p = place / spacing;
    let d = max(change / spacing, vec2(1e-6));
    let half_width = max(vec2(0.5 * width / spacing), 0.55 * d);
    let from_line = abs(fract(p - 0.5) - 0.5);
    let cover = smoothstep(half_width + 0.6 * d, half_width - 0.6 * d, from_line);
    // A line thinner than a pixel is paler.
    let pale = clamp(vec2(0.5 * width / spacing) / (0.55 * d) + 0.35, vec2(0.0), vec2(1.0));
    let crowded = 1.0 - smoothstep(vec2(0.12), vec2(0.45), d);
    let both = cover * pale * crowded;
    return max(both.x, both.y);
}

// Coverage of the single line where a coordinate is 0.
fn axis(coordinate: f32, change: f32, width: f32) -> f32 {
    let half_width = max(0.5 * width, 0.8 * change);
    return smoothstep(half_width + 0.6 * change, half_width - 0.6 * change, abs(coordinate));
}

// Mean of the mask around a pixel.
fn softened(pixel: vec2<f32>) -> vec2<f32> {
    let step = 1.25 / scene.viewport.xy;
    let at = pixel / scene.viewport.xy;
    var sum = vec2(0.0);
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let weight = f32((2 - abs(x)) * (2 - abs(y))) / 16.0;
            sum += weight * textureSampleLevel(mask, mask_sampler, at + vec2(f32(x), f32(y)) * step, 0.0).rg;
        }
    }
    return sum;
}

@fragment
fn ground_fragment(in: Surface) -> @location(0) vec4<f32> {
    let world = in.place + scene.eye.xz;
    let change = max(fwidth(in.place), vec2(1e-6));
    var colour = scene.ground.rgb;
    let close = 1.0 - smoothstep(0.002, 0.006, max(change.x, change.y));
    colour = mix(colour, scene.grid.rgb, 0.42 * close * lines(world, change, 0.1, 0.003));
    colour = mix(colour, scene.grid.rgb, lines(world, change, 1.0, 0.012));
    colour = mix(colour, scene.grid_strong.rgb, 0.9 * lines(world, change, 10.0, 0.03));
    colour = mix(colour, scene.axis_x.rgb, 0.8 * axis(world.y, change.y, 0.014));
    colour = mix(colour, scene.axis_z.rgb, 0.8 * axis(world.x, change.x, 0.014));
    let shade = softened(in.clip.xy);
    let dark = scene.shadow.a * max(shade.r * 0.72, shade.g);
    colour = mix(colour, scene.shadow.rgb, dark);
    let far = smoothstep(0.25, 1.0, length(in.place) / scene.eye.w);
    return vec4(mix(colour, scene.horizon.rgb, far), 1.0);
}

struct Sky {
    @builtin(position) clip: vec4<f32>,
    @location(0) ndc: vec2<f32>,
}

@vertex
fn sky_vertex(@builtin(vertex_index) i: u32) -> Sky {
    let p = vec2(f32((i << 1u) & 2u), f32(i & 2u)) * 2.0 - 1.0;
    return Sky(vec4(p, 0.0, 1.0), p);
}

@fragment
fn sky_fragment(in: Sky) -> @location(0) vec4<f32> {
    let direction = scene.forward.xyz + scene.right.xyz * in.ndc.x * scene.viewport.z
        + scene.up.xyz * in.ndc.y * scene.viewport.w;
    let height = normalize(direction).y;
    return vec4(mix(scene.horizon.rgb, scene.sky.rgb, smoothstep(0.0, 0.5, height)), 1.0);
}
