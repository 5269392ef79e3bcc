// Bodies flattened onto the ground, into a mask: red is the sun's shadow, green what is close above the ground.
// Both are blended by maximum, so overlaps do not add up and order does not matter.

struct Dropped {
    @builtin(position) clip: vec4<f32>,
    @location(0) height: f32,
    @location(1) @interpolate(flat) opacity: f32,
}

fn dropped(v: BodyVertex, direction: vec3<f32>) -> Dropped {
    let p = skin(v).position;
    let height = max(p.y, 0.0);
    let q = p - direction * (p.y / direction.y);
    var out: Dropped;
    out.clip = scene.view_proj * vec4(q.x, 0.0, q.z, 1.0);
    out.height = height;
    out.opacity = unpack4x8unorm(instances[v.character].colour).a;
    return out;
}

@vertex
fn sun_vertex(v: BodyVertex) -> Dropped {
    return dropped(v, scene.sun.xyz);
}

@fragment
fn sun_fragment(in: Dropped) -> @location(0) vec4<f32> {
    let fade = 1.0 - 0.55 * smoothstep(0.0, 1.7, in.height);
    return vec4(fade * in.opacity, 0.0, 0.0, 0.0);
}

@vertex
fn contact_vertex(v: BodyVertex) -> Dropped {
    return dropped(v, vec3(0.0, 1.0, 0.0));
}

@fragment
fn contact_fragment(in: Dropped) -> @location(0) vec4<f32> {
    let near = 1.0 - smoothstep(0.0, 0.14, in.height);
    return vec4(0.0, near * in.opacity, 0.0, 0.0);
}
