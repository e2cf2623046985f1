// A loop over the particles in the 27 cells around a particle, itself included: `body` is a statement that uses the index `j`. The nine rows along x
// are three cells each that follow each other in `sorted`.
#define FOR_NEIGHBOURS(own, body)                                                                                    \
    for (int row = 0; row < 9; ++row) {                                                                              \
        ivec3 size_ = grid_size(), first_ = grid_cell(own) + ivec3(-1, row % 3 - 1, row / 3 - 1);                     \
        if (first_.y < 0 || first_.z < 0 || first_.y >= size_.y || first_.z >= size_.z) continue;                     \
        int last_ = min(first_.x + 2, size_.x - 1);                                                                  \
        first_.x = max(first_.x, 0);                                                                                 \
        uint end_ = starts[grid_index(ivec3(last_, first_.yz)) + 1u];                                                \
        for (uint j = starts[grid_index(first_)]; j < end_; ++j) body                                                \
    }
