//! The executor on a real device, under the validation layer with synchronization validation. Without a driver these tests fail.

mod allocation;
mod bindings;
mod frames;
mod hang;
mod lab;
mod shown;
