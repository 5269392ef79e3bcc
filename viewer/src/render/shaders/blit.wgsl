// The finished picture into the window's own pass.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) at: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) i: u32) -> Corner {
    let p = vec2(f32((i << 1u) & 2u), f32(i & 2u));
    return Corner(vec4(p * 2.0 - 1.0, 0.0, 1.0), vec2(p.x, 1.0 - p.y));
}

// For targets that convert from linear light themselves.
@fragment
fn linear_fragment(in: Corner) -> @location(0) vec4<f32> {
    return vec4(textureSample(picture, picture_sampler, in.at).rgb, 1.0);
}

// For targets that store what they are given: encoded here.
@fragment
fn encoded_fragment(in: Corner) -> @location(0) vec4<f32> {
    let c = textureSample(picture, picture_sampler, in.at).rgb;
    let encoded = select(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3(0.0031308));
    return vec4(encoded, 1.0);
}
