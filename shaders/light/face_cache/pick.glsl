// The pixel that stands for a cell in a frame: of all that see it, the one with the highest rank. Ranks follow from the pixel and the frame, so the order of
// threads does not matter, and each pixel has its turn.

uint pick_rank(uint pixel, uint turn) {
    uint mixed = pixel * 0x9e3779b1u;
    mixed ^= mixed >> 16;
    return mixed * 0x85ebca6bu + rx_hash(turn);
}

uint pick_pixel(uint rank, uint turn) {
    uint mixed = (rank - rx_hash(turn)) * 0xa5cb9243u;
    mixed ^= mixed >> 16;
    return mixed * 0x0e8b2f51u;
}
