"""Where frames come from: CAN interfaces that are only listened to, and recordings of them."""
