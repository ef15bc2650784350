"""Robot arms: any Drake `MultibodyPlant` held against a log of its joints."""
