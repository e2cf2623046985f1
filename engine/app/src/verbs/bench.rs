//! `raxel bench`: measurements that others can repeat.
