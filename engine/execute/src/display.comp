#version 460
// Shows one debug target: reads one mip and layer (or slice, or a buffer), maps its values to colour, writes the picture. Compiled once per
// kind of source: RX_FLOAT, RX_INT or RX_UINT is the type of a fetch; RX_VOLUME a 3-D image; RX_BUFFER a buffer. With RX_COPY it writes the
// words of the source to the reference, and no picture.
layout(local_size_x = 8, local_size_y = 8) in;

#if defined(RX_BUFFER)
layout(std430, set = 0, binding = 0) readonly buffer Source { uint words[]; } source;
#elif defined(RX_VOLUME) && defined(RX_FLOAT)
layout(set = 0, binding = 0) uniform sampler3D source;
#elif defined(RX_VOLUME) && defined(RX_INT)
layout(set = 0, binding = 0) uniform isampler3D source;
#elif defined(RX_VOLUME)
layout(set = 0, binding = 0) uniform usampler3D source;
#elif defined(RX_FLOAT)
layout(set = 0, binding = 0) uniform sampler2DArray source;
#elif defined(RX_INT)
layout(set = 0, binding = 0) uniform isampler2DArray source;
#else
layout(set = 0, binding = 0) uniform usampler2DArray source;
#endif
#if !defined(RX_COPY)
layout(set = 0, binding = 1, rgba8) writeonly uniform image2D picture;
#endif
// The reference that the debug target is compared with: of each texel push.reference_channels words.
#if !defined(RX_COPY)
readonly
#endif
layout(std430, set = 0, binding = 2) buffer Reference { uint words[]; } reference;

layout(push_constant) uniform Push {
    ivec2 output_extent;  // pixels of the picture
    ivec2 source_extent;  // texels of the shown mip; for a buffer, elements a row and rows
    vec2 range;           // values at the ends of the map
    uint map;             // DisplayMap in its order of declaration
    uint channel;         // channel that scalar maps read
    uint channels;        // channels that the source has, 1 to 4; for a buffer, 32-bit words an element
    uint slice;           // layer, or z of a volume (the view starts at the shown mip)
    uint elements;        // of a buffer: how many whole elements it has
    uint comparison;      // how it is shown with the reference: 0 without, WIPE, REFERENCE, DIFFERENCE
    vec2 origin;          // texel at the top left corner of the picture
    vec2 step;            // texels a pixel; 0 shows the whole
    float gain;           // the factor of differences
    int edge;             // of a wipe: the first pixel of a row that shows the reference
    uint reference_channels;  // channels that the reference has, 1 to 4
    uint reference_values;    // the type of its words: 0 floats, 1 integers, 2 DISPLAYED
} push;

const uint WIPE = 1u, REFERENCE = 2u, DIFFERENCE = 3u;
const uint DISPLAYED = 2u;
const uint COLOR = 0u, RAW = 1u, GRAY = 2u, TURBO = 3u, VIRIDIS = 4u, NORMAL = 5u, ID = 6u, INTEGER = 7u;

// IEC 61966-2-1, linear to encoded.
vec3 srgb(vec3 linear) {
    return mix(linear * 12.92, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, greaterThan(linear, vec3(0.0031308)));
}

// Polynomial fit of the Turbo map (A. Mikhailov, Google AI blog, 2019; fit by R. Du).
vec3 turbo(float x) {
    vec4 v4 = vec4(1.0, x, x * x, x * x * x);
    vec2 v2 = v4.zw * v4.z;
    return vec3(dot(v4, vec4(0.13572138, 4.61539260, -42.66032258, 132.13108234)) + dot(v2, vec2(-152.94239396, 59.28637943)),
                dot(v4, vec4(0.09140261, 2.19418839, 4.84296658, -14.18503333)) + dot(v2, vec2(4.27729857, 2.82956604)),
                dot(v4, vec4(0.10667330, 12.64194608, -60.58204836, 110.36276771)) + dot(v2, vec2(-89.90310912, 27.34824973)));
}

// Polynomial fit of matplotlib's Viridis (M. Zucker, 2019).
vec3 viridis(float x) {
    const vec3 c0 = vec3(0.27772733, 0.00540734, 0.33409981), c1 = vec3(0.10509304, 1.40461353, 1.38459016);
    const vec3 c2 = vec3(-0.33086183, 0.21484756, 0.09509516), c3 = vec3(-4.63423050, -5.79910097, -19.33244096);
    const vec3 c4 = vec3(6.22826994, 14.17993337, 56.69055260), c5 = vec3(4.77638500, -13.74514538, -65.35303263);
    const vec3 c6 = vec3(-5.43545586, 4.64585261, 26.31243525);
    return c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * (c5 + x * c6)))));
}

// Integer finaliser of MurmurHash3 (A. Appleby).
uint scramble(uint x) {
    x = (x ^ (x >> 16)) * 0x85ebca6bu;
    x = (x ^ (x >> 13)) * 0xc2b2ae35u;
    return x ^ (x >> 16);
}

vec3 id_color(uvec4 id, uint channels) {
    uint hash = 0u, any_bit = 0u;
    for (uint c = 0u; c < min(channels, 4u); ++c) {
        hash = scramble(hash ^ (id[c] + 0x9e3779b9u * (c + 1u)));
        any_bit |= id[c];
    }
    return any_bit == 0u ? vec3(0.0) : 0.25 + 0.75 * vec3(hash & 255u, (hash >> 8) & 255u, (hash >> 16) & 255u) / 255.0;
}

float unit(float value) {
    return clamp((value - push.range.x) / max(abs(push.range.y - push.range.x), 1e-30) * sign(push.range.y - push.range.x), 0.0, 1.0);
}

// NaN is magenta, infinity yellow, in a checker that no map can make.
vec3 warning(bool nan, ivec2 pixel) {
    bool dark = ((pixel.x >> 2) + (pixel.y >> 2) & 1) == 1;
    return (nan ? vec3(1.0, 0.0, 1.0) : vec3(1.0, 0.9, 0.0)) * (dark ? 0.4 : 1.0);
}

vec3 show_float(vec4 value, uint channels, ivec2 pixel) {
    for (uint c = 0u; c < min(channels, 4u); ++c) {
        // Bits, not isnan(): a driver may assume that NaN does not occur.
        uint magnitude = floatBitsToUint(value[c]) & 0x7fffffffu;
        if (magnitude >= 0x7f800000u) return warning(magnitude > 0x7f800000u, pixel);
    }
    float x = unit(value[push.channel]);
    vec3 rgb = channels == 1u ? value.rrr : channels == 2u ? vec3(value.rg, 0.0) : value.rgb;
    switch (push.map) {
        case COLOR: return srgb(vec3(unit(rgb.r), unit(rgb.g), unit(rgb.b)));
        case RAW: return clamp(rgb, 0.0, 1.0);
        case TURBO: return clamp(turbo(x), 0.0, 1.0);
        case VIRIDIS: return clamp(viridis(x), 0.0, 1.0);
        case NORMAL: return 0.5 + 0.5 * clamp(rgb, -1.0, 1.0);
        case ID: return id_color(floatBitsToUint(value), channels);
        default: return vec3(x);
    }
}

vec3 show_integer(uvec4 bits, float scalar, uint channels) {
    float x = unit(scalar);
    switch (push.map) {
        case ID: return id_color(bits, channels);
        case TURBO: return clamp(turbo(x), 0.0, 1.0);
        case VIRIDIS: return clamp(viridis(x), 0.0, 1.0);
        default: return vec3(x);
    }
}

// The word of an integer as a number.
float number(uint word) {
#if defined(RX_INT)
    return float(int(word));
#else
    return float(word);
#endif
}

// The words of a texel of the debug target.
uvec4 fetch(ivec2 texel) {
#if defined(RX_BUFFER)
    uint element = uint(texel.y) * uint(push.source_extent.x) + uint(texel.x);
    uvec4 words = uvec4(0);
    for (uint c = 0u; c < min(push.channels, 4u); ++c) words[c] = source.words[element * push.channels + c];
    return words;
#elif defined(RX_FLOAT)
    return floatBitsToUint(texelFetch(source, ivec3(texel, int(push.slice)), 0));
#else
    return uvec4(texelFetch(source, ivec3(texel, int(push.slice)), 0));
#endif
}

// The words of a texel of the reference.
uvec4 fetch_reference(ivec2 texel) {
    uint at = (uint(texel.y) * uint(push.source_extent.x) + uint(texel.x)) * push.reference_channels;
    uvec4 words = uvec4(0);
    for (uint c = 0u; c < min(push.reference_channels, 4u); ++c) words[c] = reference.words[at + c];
    return words;
}

vec3 show(uvec4 words, uint channels, ivec2 pixel) {
#if defined(RX_FLOAT)
    return show_float(uintBitsToFloat(words), channels, pixel);
#else
    return show_integer(words, number(words[push.channel]), channels);
#endif
}

vec3 show_reference(uvec4 words, ivec2 pixel) {
    if (push.reference_values == DISPLAYED) return uintBitsToFloat(words.rgb);
    return show(words, push.reference_channels, pixel);
}

// Orange where it is positive, blue where it is negative.
vec3 signed_color(float difference) {
    float size = min(abs(difference), 1.0);
    return size * (difference > 0.0 ? vec3(1.0, 0.6, 0.1) : vec3(0.1, 0.5, 1.0));
}

// Shown minus reference. Colours by channel around a grey, numbers by sign; both in units of the range.
vec3 show_difference(uvec4 a, uvec4 b, ivec2 pixel) {
    if (push.reference_values == DISPLAYED) return 0.5 + push.gain * (show(a, push.channels, pixel) - uintBitsToFloat(b.rgb));
    if (push.map == ID) return vec3(any(notEqual(a, b)) ? 1.0 : 0.0);
    float width = abs(push.range.y - push.range.x);
    float scale = push.gain / max(push.map == RAW || push.map == NORMAL ? 1.0 : width, 1e-30);
#if defined(RX_FLOAT)
    vec4 x = uintBitsToFloat(a), y = uintBitsToFloat(b);
    uint channels = min(min(push.channels, push.reference_channels), 4u);
    for (uint c = 0u; c < channels; ++c) {
        uint magnitude = max(a[c] & 0x7fffffffu, b[c] & 0x7fffffffu);
        if (magnitude >= 0x7f800000u && a[c] != b[c]) return warning(magnitude > 0x7f800000u, pixel);
    }
    bool colored = channels >= 3u && (push.map == COLOR || push.map == RAW || push.map == NORMAL);
    // The same infinity is no difference.
    vec4 difference = mix(x - y, vec4(0.0), equal(a, b));
    return colored ? 0.5 + scale * difference.rgb : signed_color(scale * difference[push.channel]);
#else
    return signed_color(scale * (number(a[push.channel]) - number(b[push.channel])));
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, push.output_extent))) return;
    // Nearest texel. The whole picture by integer arithmetic, so that equal extents copy exactly.
    ivec2 texel = pixel * push.source_extent / push.output_extent;
    if (push.step.x > 0.0) {
        vec2 place = push.origin + (vec2(pixel) + 0.5) * push.step;
        texel = clamp(ivec2(floor(place)), ivec2(0), push.source_extent - 1);
    }
#if defined(RX_COPY)
    uvec4 words = fetch(texel);
    uint at = (uint(texel.y) * uint(push.source_extent.x) + uint(texel.x)) * push.channels;
    for (uint c = 0u; c < min(push.channels, 4u); ++c) reference.words[at + c] = words[c];
#else
    vec3 rgb = vec3(0.0);
#if defined(RX_BUFFER)
    // The last row may be short.
    if (uint(texel.y) * uint(push.source_extent.x) + uint(texel.x) >= push.elements) {
        imageStore(picture, pixel, vec4(rgb, 1.0));
        return;
    }
#endif
    bool reads_reference = push.comparison >= REFERENCE || (push.comparison == WIPE && pixel.x >= push.edge);
    if (!reads_reference) {
        rgb = show(fetch(texel), push.channels, pixel);
    } else if (push.comparison == DIFFERENCE) {
        rgb = clamp(show_difference(fetch(texel), fetch_reference(texel), pixel), 0.0, 1.0);
    } else {
        rgb = show_reference(fetch_reference(texel), pixel);
    }
    imageStore(picture, pixel, vec4(rgb, 1.0));
#endif
}
