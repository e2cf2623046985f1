//! raxel
