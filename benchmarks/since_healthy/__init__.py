"""What has happened since a machine whose controller nobody knows was healthy: one value changed, one effect begun, or nothing."""
