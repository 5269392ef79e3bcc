// Lines, round cones and rings, one instance each.

struct LineIn {
    @builtin(vertex_index) index: u32,
    @location(0) a: vec3<f32>,
    @location(1) width: f32,
    @location(2) b: vec3<f32>,
    @location(3) on_top: u32,
    @location(4) colour: vec4<f32>,
}

struct LineOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(linear) across: f32,
    @location(1) @interpolate(flat) half_width: f32,
    @location(2) @interpolate(flat) colour: vec4<f32>,
}

// Lines and rings lie a little nearer than what they are drawn on.
const NEARER: f32 = 1.003;

@vertex
fn line_vertex(in: LineIn) -> LineOut {
    var a = scene.view_proj * vec4(in.a, 1.0);
    var b = scene.view_proj * vec4(in.b, 1.0);
    // With reversed depth, z is the distance of the near plane: what has a smaller w is behind it.
    let near = max(a.z, 1e-6);
    var out: LineOut;
    out.colour = vec4(to_linear(in.colour.rgb), in.colour.a * clamp(in.width, 0.0, 1.0));
    if a.w < near && b.w < near {
        out.clip = vec4(2.0, 2.0, 2.0, 1.0);
        return out;
    }
    let from_a = a;
    if a.w < near { a = mix(a, b, (near - a.w) / (b.w - a.w)); }
    if b.w < near { b = mix(b, from_a, (near - b.w) / (from_a.w - b.w)); }
    let half_size = 0.5 * scene.viewport.xy;
    let along = (b.xy / b.w - a.xy / a.w) * half_size;
    let span = length(along);
    let direction = select(vec2(1.0, 0.0), along / span, span > 1e-6);
    let end = f32(in.index & 1u);
    let side = f32((in.index >> 1u) & 1u) * 2.0 - 1.0;
    out.half_width = 0.5 * max(in.width, 1.0);
    let reach = out.half_width + 0.75;
    let at = select(a, b, end > 0.5);
    let offset = vec2(-direction.y, direction.x) * side * reach + direction * (end * 2.0 - 1.0) * 0.4 * out.half_width;
    let clip = vec4(at.xy + offset / half_size * at.w, at.z * NEARER, at.w);
    out.clip = layered(clip, in.on_top);
    out.across = side * reach;
    return out;
}

@fragment
fn line_fragment(in: LineOut) -> @location(0) vec4<f32> {
    let cover = clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0);
    return vec4(in.colour.rgb, in.colour.a * cover);
}

struct RoundIn {
    @location(0) direction: vec3<f32>,
    @location(1) end: f32,
    @location(2) a: vec3<f32>,
    @location(3) radius_a: f32,
    @location(4) b: vec3<f32>,
    @location(5) radius_b: f32,
    @location(6) on_top: u32,
    @location(7) colour: vec4<f32>,
}

struct RoundOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) world: vec3<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
}

@vertex
fn round_vertex(in: RoundIn) -> RoundOut {
    let axis = in.b - in.a;
    let span = length(axis);
    let y = select(vec3(0.0, 1.0, 0.0), axis / span, span > 1e-6);
    let guide = select(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), abs(y.z) > 0.7);
    let x = normalize(cross(y, guide));
    let normal = x * in.direction.x + y * in.direction.y + cross(x, y) * in.direction.z;
    let world = mix(in.a, in.b, in.end) + normal * mix(in.radius_a, in.radius_b, in.end);
    var out: RoundOut;
    out.clip = layered(scene.view_proj * vec4(world, 1.0), in.on_top);
    out.normal = normal;
    out.world = world;
    out.colour = vec4(to_linear(in.colour.rgb), in.colour.a);
    return out;
}

@fragment
fn round_fragment(in: RoundOut) -> @location(0) vec4<f32> {
    return vec4(lit(in.colour.rgb, in.normal, in.world), in.colour.a);
}

struct RingIn {
    @builtin(vertex_index) index: u32,
    @location(0) centre: vec3<f32>,
    @location(1) inner: f32,
    @location(2) outer: f32,
    @location(3) on_top: u32,
    @location(4) colour: vec4<f32>,
}

struct RingOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec2<f32>,
    @location(1) @interpolate(flat) radii: vec2<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
}

@vertex
fn ring_vertex(in: RingIn) -> RingOut {
    let corner = vec2(f32(in.index & 1u), f32((in.index >> 1u) & 1u)) * 2.0 - 1.0;
    let place = corner * in.outer * 1.05;
    let clip = scene.view_proj * vec4(in.centre + vec3(place.x, 0.0, place.y), 1.0);
    var out: RingOut;
    out.clip = layered(vec4(clip.xy, clip.z * NEARER, clip.w), in.on_top);
    out.place = place;
    out.radii = vec2(in.inner, in.outer);
    out.colour = vec4(to_linear(in.colour.rgb), in.colour.a);
    return out;
}

@fragment
fn ring_fragment(in: RingOut) -> @location(0) vec4<f32> {
    // What has no inner radius is a square.
    let radius = select(length(in.place), max(abs(in.place.x), abs(in.place.y)), in.radii.x < 0.0);
    let change = max(fwidth(radius), 1e-6);
    let outside = clamp((in.radii.y - radius) / change + 0.5, 0.0, 1.0);
    let inside = select(1.0, clamp((radius - in.radii.x) / change + 0.5, 0.0, 1.0), in.radii.x > 0.0);
    return vec4(in.colour.rgb, in.colour.a * outside * inside);
}
