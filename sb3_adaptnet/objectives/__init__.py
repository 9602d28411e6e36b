"""What training maximises: imitation, goal and further rewards, their advantages and step sizes."""
