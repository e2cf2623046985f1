// Keys of the keyboard. Bind `keys` to a buffer with `source = "input.keys"`. A key is a place on the keyboard, independent of its label:
// RX_KEY_W is the key left of E on an English keyboard. Its number is the usage of USB HID, page 7.
#ifndef RAXEL_KEYS_GLSL
#define RAXEL_KEYS_GLSL

layout(std430) readonly buffer RxKeys {
    uint words[];  // a bit for each key: eight words of keys that are held, eight of pressed and eight of toggled keys
} keys;

// A bit of one of the three sets of keys.
bool rx_key_bit(uint set, uint key) {
    return key < 256u && (keys.words[8u * set + (key >> 5)] >> (key & 31u) & 1u) != 0u;
}

// Whether a key is held. A short press lasts for one frame at least.
bool rx_key(uint key) {
    return rx_key_bit(0u, key);
}

// Whether a key went down since the last frame.
bool rx_key_pressed(uint key) {
    return rx_key_bit(1u, key);
}

// Changes with each press of a key, and is false at first.
bool rx_key_toggled(uint key) {
    return rx_key_bit(2u, key);
}

const uint RX_KEY_A = 4u;
const uint RX_KEY_B = 5u;
const uint RX_KEY_C = 6u;
const uint RX_KEY_D = 7u;
const uint RX_KEY_E = 8u;
const uint RX_KEY_F = 9u;
const uint RX_KEY_G = 10u;
const uint RX_KEY_H = 11u;
const uint RX_KEY_I = 12u;
const uint RX_KEY_J = 13u;
const uint RX_KEY_K = 14u;
const uint RX_KEY_L = 15u;
const uint RX_KEY_M = 16u;
const uint RX_KEY_N = 17u;
const uint RX_KEY_O = 18u;
const uint RX_KEY_P = 19u;
const uint RX_KEY_Q = 20u;
const uint RX_KEY_R = 21u;
const uint RX_KEY_S = 22u;
const uint RX_KEY_T = 23u;
const uint RX_KEY_U = 24u;
const uint RX_KEY_V = 25u;
const uint RX_KEY_W = 26u;
const uint RX_KEY_X = 27u;
const uint RX_KEY_Y = 28u;
const uint RX_KEY_Z = 29u;
const uint RX_KEY_1 = 30u;
const uint RX_KEY_2 = 31u;
const uint RX_KEY_3 = 32u;
const uint RX_KEY_4 = 33u;
const uint RX_KEY_5 = 34u;
const uint RX_KEY_6 = 35u;
const uint RX_KEY_7 = 36u;
const uint RX_KEY_8 = 37u;
const uint RX_KEY_9 = 38u;
const uint RX_KEY_0 = 39u;
const uint RX_KEY_ENTER = 40u;
const uint RX_KEY_ESCAPE = 41u;
const uint RX_KEY_BACKSPACE = 42u;
const uint RX_KEY_TAB = 43u;
const uint RX_KEY_SPACE = 44u;
const uint RX_KEY_MINUS = 45u;
const uint RX_KEY_EQUAL = 46u;
const uint RX_KEY_BRACKET_LEFT = 47u;
const uint RX_KEY_BRACKET_RIGHT = 48u;
const uint RX_KEY_BACKSLASH = 49u;
const uint RX_KEY_SEMICOLON = 51u;
const uint RX_KEY_QUOTE = 52u;
const uint RX_KEY_BACKQUOTE = 53u;
const uint RX_KEY_COMMA = 54u;
const uint RX_KEY_PERIOD = 55u;
const uint RX_KEY_SLASH = 56u;
const uint RX_KEY_CAPS_LOCK = 57u;
const uint RX_KEY_F1 = 58u;
const uint RX_KEY_F2 = 59u;
const uint RX_KEY_F3 = 60u;
const uint RX_KEY_F4 = 61u;
const uint RX_KEY_F5 = 62u;
const uint RX_KEY_F6 = 63u;
const uint RX_KEY_F7 = 64u;
const uint RX_KEY_F8 = 65u;
const uint RX_KEY_F9 = 66u;
const uint RX_KEY_F10 = 67u;
const uint RX_KEY_F11 = 68u;
const uint RX_KEY_F12 = 69u;
const uint RX_KEY_PRINT_SCREEN = 70u;
const uint RX_KEY_SCROLL_LOCK = 71u;
const uint RX_KEY_PAUSE = 72u;
const uint RX_KEY_INSERT = 73u;
const uint RX_KEY_HOME = 74u;
const uint RX_KEY_PAGE_UP = 75u;
const uint RX_KEY_DELETE = 76u;
const uint RX_KEY_END = 77u;
const uint RX_KEY_PAGE_DOWN = 78u;
const uint RX_KEY_ARROW_RIGHT = 79u;
const uint RX_KEY_ARROW_LEFT = 80u;
const uint RX_KEY_ARROW_DOWN = 81u;
const uint RX_KEY_ARROW_UP = 82u;
const uint RX_KEY_NUM_LOCK = 83u;
const uint RX_KEY_NUMPAD_DIVIDE = 84u;
const uint RX_KEY_NUMPAD_MULTIPLY = 85u;
const uint RX_KEY_NUMPAD_SUBTRACT = 86u;
const uint RX_KEY_NUMPAD_ADD = 87u;
const uint RX_KEY_NUMPAD_ENTER = 88u;
const uint RX_KEY_NUMPAD_1 = 89u;
const uint RX_KEY_NUMPAD_2 = 90u;
const uint RX_KEY_NUMPAD_3 = 91u;
const uint RX_KEY_NUMPAD_4 = 92u;
const uint RX_KEY_NUMPAD_5 = 93u;
const uint RX_KEY_NUMPAD_6 = 94u;
const uint RX_KEY_NUMPAD_7 = 95u;
const uint RX_KEY_NUMPAD_8 = 96u;
const uint RX_KEY_NUMPAD_9 = 97u;
const uint RX_KEY_NUMPAD_0 = 98u;
const uint RX_KEY_NUMPAD_DECIMAL = 99u;
const uint RX_KEY_INTL_BACKSLASH = 100u;
const uint RX_KEY_CONTEXT_MENU = 101u;
const uint RX_KEY_CONTROL_LEFT = 224u;
const uint RX_KEY_SHIFT_LEFT = 225u;
const uint RX_KEY_ALT_LEFT = 226u;
const uint RX_KEY_META_LEFT = 227u;
const uint RX_KEY_CONTROL_RIGHT = 228u;
const uint RX_KEY_SHIFT_RIGHT = 229u;
const uint RX_KEY_ALT_RIGHT = 230u;
const uint RX_KEY_META_RIGHT = 231u;

#endif
