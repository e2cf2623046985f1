// A layer of thin clouds: fractal noise on a plane high above, lit by the sun from one side. No ray is marched.

float cloud_value(ivec2 cell) {
    return float(rx_hash(uint(cell.x) + rx_hash(uint(cell.y))) >> 8) * 5.9604644775390625e-8;
}

float cloud_noise(vec2 at) {
    vec2 cell = floor(at), part = at - cell;
    part = part * part * (3.0 - 2.0 * part);
    ivec2 c = ivec2(cell);
    return mix(mix(cloud_value(c), cloud_value(c + ivec2(1, 0)), part.x),
               mix(cloud_value(c + ivec2(0, 1)), cloud_value(c + ivec2(1, 1)), part.x), part.y);
}

float cloud_thickness(vec2 at, float share) {
    float sum = 0.0, weight = 0.5;
    for (int i = 0; i < 5; ++i) {
        sum += weight * cloud_noise(at);
        at = mat2(1.6, 1.2, -1.2, 1.6) * at + 17.3;
        weight *= 0.5;
    }
    return max(sum - (1.0 - share) * 0.9, 0.0);
}

// The sky's light behind and of the clouds; `cover` is how much of what is behind they hide.
vec3 with_clouds(vec3 sky, vec3 dir, vec3 sun, float share, out float cover) {
    vec2 at = dir.xz / (dir.y + 0.12) * 1.3, towards = normalize(sun.xz + vec2(1e-4)) * 0.12;
    float here = cloud_thickness(at, share), beside = cloud_thickness(at + towards, share);
    cover = (1.0 - exp(-5.0 * here)) * smoothstep(0.02, 0.22, dir.y);
    // Bright where it gets thinner towards the sun, and at its edges when the sun is behind it.
    float lit = exp(-4.0 * beside), silver = pow(max(dot(dir, sun), 0.0), 8.0) * exp(-6.0 * here);
    vec3 ambient = sky_radiance(vec3(0.0, 1.0, 0.0), sun) * 0.9 + sky * 0.4;
    vec3 cloud = ambient + sun_irradiance(sun) * (0.16 * lit + 0.5 * silver);
    return mix(sky, cloud, cover);
}
