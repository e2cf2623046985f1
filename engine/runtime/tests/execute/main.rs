//! The executor on a real device, under the validation layer with synchronization validation. Without a driver these tests fail.

mod bindings;
mod frames;
mod lab;
mod shown;
